"""Places of pulses against Poisson's law written out place by place."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import logsumexp
from scipy.stats import poisson

from physics.clock import Clock
from physics.pulse import tailed_pulse
from physics.roaming import SMALL, _log1p, clear_evidence, pulses_in_bins, roaming

WIDTH, BINS, ZONES = 0.26e-9, 30, 3
CLOCK = Clock(WIDTH, BINS, np.full(ZONES, 1e-9), tailed_pulse(0.2e-9, 0.3e-9, 0.4e-9, 0.1, step_s=WIDTH / 16))
SHARES = pulses_in_bins(CLOCK.pulse, BINS, WIDTH)


def frames(seed, count, counts, present=1.0):
    """Counts of frames of which some hold a pulse, what is expected without it, and its place, -1 for none."""
    rng = np.random.default_rng(seed)
    mean = 3 + 40 * np.exp(-(((np.arange(BINS) - 12) / 2) ** 2)) * rng.uniform(0.5, 1, (count, ZONES, 1))
    place = np.where(rng.random(count) < present, rng.integers(len(SHARES), size=count), -1)
    pulse = np.where(place[:, None] >= 0, SHARES[place], 0)
    return rng.poisson(mean + counts[:, None] * pulse[:, None]).astype(float), mean, place


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 1000), st.floats(0.5, 200), st.floats(0.05, 0.95))
def test_the_evidence_is_the_mean_likelihood_over_all_places(seed, strength, present):
    counts = strength * np.array([1, 0.4, 0.0])
    recorded, mean, _ = frames(seed, 4, counts, present)
    # All of it is background: frames have no brightness of their own.
    found = roaming(recorded, mean, mean, CLOCK, counts, present)
    none = poisson.logpmf(recorded, mean).sum(axis=(1, 2))
    each = [poisson.logpmf(recorded, mean + counts[:, None] * s).sum(axis=(1, 2)) for s in SHARES]
    some = logsumexp(each, axis=0) - np.log(len(SHARES))
    whole = np.logaddexp(np.log(1 - present) + none, np.log(present) + some)
    np.testing.assert_allclose(found.evidence, 2 * (whole - none), atol=0.02)
    chances = np.exp(np.log(present / len(SHARES)) + np.array(each) - whole).T
    np.testing.assert_allclose(found.chances, chances, atol=1e-3)
    np.testing.assert_allclose(found.added, np.einsum("fk,kt,p->fpt", chances, SHARES, counts), atol=1e-3 * strength)
    reached = poisson.logpmf(recorded, mean + found.added).sum(axis=(1, 2))
    np.testing.assert_allclose(found.flattery, 2 * (reached - whole), atol=0.03)
    # A mean of rates is at least as likely as the mean of likelihoods.
    assert (found.flattery > -0.02).all()
    assert (found.blur > -1e-9).all()


@pytest.mark.parametrize("times", [1e-9, 1e-3, 0.3, 0.999, 1.0, 1.001, 30.0])
def test_the_series_of_a_small_logarithm_is_that_logarithm(times):
    """On both sides of where one takes over from the other, to less than its next term."""
    assert _log1p(times * SMALL) == pytest.approx(np.log1p(times * SMALL), rel=3e-13, abs=0)


def test_slopes_are_differences_of_the_evidence():
    counts, present = np.array([20.0, 9, 5]), 0.7
    recorded, mean, _ = frames(3, 6, counts, present)

    def half(c, q):
        return roaming(recorded, mean, mean, CLOCK, c, q).evidence / 2

    found = roaming(recorded, mean, mean, CLOCK, counts, present)
    for zone, step in enumerate(1e-3 * np.eye(ZONES)):
        slope = (half(counts + step, present) - half(counts - step, present)) / 2e-3
        np.testing.assert_allclose(found.by_counts[:, zone], slope, atol=1e-4)
    slope = (half(counts, present + 1e-4) - half(counts, present - 1e-4)) / 2e-4
    np.testing.assert_allclose(found.by_present, slope, rtol=1e-4, atol=1e-4)


def test_a_bright_pulse_is_found_where_it_is_and_missed_where_there_is_none():
    counts = np.array([300.0, 300, 300])
    recorded, mean, place = frames(5, 40, counts, 0.5)
    found = roaming(recorded, mean, 3.0, CLOCK, counts, 0.5)
    there = place >= 0
    # Half a pulse that falls out of the window may be taken for another place.
    inside = there & (place > 8) & (place < len(SHARES) - 8)
    assert np.abs(found.chances.argmax(axis=1) - place)[inside].max() <= 1
    assert found.chances[~there].sum(axis=1).max() < 0.05
    assert found.blur[inside].max() < 0.05 * 3 * 300


def test_a_frame_that_is_brighter_all_over_holds_no_pulse():
    mean = 3 + 3000 * np.exp(-(((np.arange(BINS) - 12) / 2) ** 2)) * np.ones((1, ZONES, 1))
    found = roaming(3 + 1.05 * (mean - 3), mean, 3.0, CLOCK, np.full(ZONES, 100.0), 0.5)
    assert found.evidence[0] < 0


def test_a_dead_zone_says_nothing():
    counts = np.array([30.0, 30, 30])
    recorded, mean, _ = frames(7, 5, counts)
    recorded[:, 1] = 0
    found = roaming(recorded, mean, mean, CLOCK, counts, 0.8)
    alone = roaming(recorded[:, ::2], mean[:, ::2], mean[:, ::2], CLOCK, counts[::2], 0.8)
    np.testing.assert_allclose(found.evidence, alone.evidence)
    assert not found.by_counts[:, 1].any()


def test_evidence_of_clear_places_is_the_mean_over_them():
    counts = np.array([0.0, 0, 60])
    recorded, mean, _ = frames(8, 20, counts)
    found = clear_evidence(recorded, mean, mean, CLOCK, 50.0, [0.8])[0]
    # All of it is background: every place is clear.
    for zone in range(ZONES):
        alone = roaming(recorded, mean, mean, CLOCK, 50.0 * (np.arange(ZONES) == zone), 0.8)
        assert found[1 + zone] == pytest.approx(alone.evidence.sum())
    alike = roaming(recorded, mean, mean, CLOCK, np.full(ZONES, 50.0), 0.8)
    assert found[0] == pytest.approx(alike.evidence.sum())
    assert found.argmax() == 3


def test_a_surface_brighter_than_thought_is_no_evidence():
    mean = 3 + 40 * np.exp(-(((np.arange(BINS) - 12) / 2) ** 2)) * np.ones((20, ZONES, 1))
    brighter = mean + np.array([0, 0, 5])[:, None] * (mean - 3) * (np.arange(20) % 2)[:, None, None]
    recorded = np.random.default_rng(9).poisson(brighter).astype(float)
    seen = recorded, mean, 3.0, CLOCK
    assert roaming(*seen, np.array([0, 0, 300.0]), 0.5).evidence.sum() > 100
    assert max(clear_evidence(*seen, counts, [0.5])[0, 3] for counts in (5.0, 30.0, 150.0, 700.0)) < 12


def test_noise_makes_no_evidence():
    """Its exponential has mean 1 over noise, whatever is looked for."""
    rng = np.random.default_rng(11)
    mean = np.full((3000, ZONES, BINS), 4.0)
    found = roaming(rng.poisson(mean).astype(float), mean, mean, CLOCK, np.full(ZONES, 6.0), 0.5)
    ratio = np.exp(found.evidence / 2)
    assert ratio.mean() == pytest.approx(1, abs=5 * ratio.std() / np.sqrt(len(ratio)))

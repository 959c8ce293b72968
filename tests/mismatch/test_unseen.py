"""Counts that an effect leaves uncertain: how likely they are, by how much it is right, how far they are trusted."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm

from mismatch import unseen
from mismatch.fit import fit, fit_nominal, on_others
from mismatch.form import forms_of
from mismatch.unseen import marginal_deviance, owns_up, trust_in
from physics.effects import find_effect
from physics.effects.time_lag import TimeLag
from physics.owning import Unseen

LAG = next(form for form in forms_of(find_effect("time_lag"), {"zone": 4, "bin": 48}) if form.free == ("lag",))


@pytest.fixture
def uncertain(drawn, rig, simulated, monkeypatch):
    """uncertain(times, more): a lag's fit of counts that scatter `times` as much as it owns up to, (F, P, T) `more`."""

    def make(times, more=2.0, together=1.0, chance=None):
        rng, at_most = np.random.default_rng(6), None if chance is None else np.full(len(chance), 30.0)
        mean = rig.expected(find_effect("time_lag").at(lag=0.01)) + 200
        variance = more * mean * (rng.random(mean.shape) < 0.5)
        monkeypatch.setattr(
            TimeLag, "unseen", lambda self, values, rendering: Unseen(variance, together, None, at_most)
        )
        scatter = np.sqrt(mean + times * variance * np.reshape(1.0 if chance is None else chance, (-1, 1, 1)))
        counts = np.rint(np.maximum(rng.normal(mean, scatter), 0))
        simulation = simulated(counts)
        simulation = replace(simulation, background=simulation.background + 200)
        start = np.append(fit_nominal(simulation).x, LAG.beginning({"lag": 0.01}).at_start())
        return simulation, fit(simulation, (LAG,), start), variance

    return make


@pytest.mark.parametrize("times", [0.3, 1.0, 3.0])
def test_by_how_much_counts_scatter_more_they_tell_themselves(uncertain, times):
    simulation, found, variance = uncertain(times)
    trust = trust_in(simulation, found)
    told = 1 / trust - 1
    assert owns_up(found)
    assert told[variance > 0] == pytest.approx(times * variance[variance > 0] / found.expected[variance > 0], rel=0.15)
    assert (trust[variance == 0] == 1).all()
    # Those off alike are trusted less, though each by itself is as likely.
    simulation, found, _ = uncertain(times, together=5.0)
    np.testing.assert_allclose(1 / trust_in(simulation, found) - 1, 5 * told, rtol=0.01, atol=1e-9)


def test_a_frame_that_is_off_by_much_by_chance_is_trusted_less_and_that_has_a_price(uncertain):
    """What seldom happens is large when it does: of all frames alike it would be far too much."""
    chance = np.ones(24)
    chance[[5, 17]] = 20.0
    simulation, found, variance = uncertain(1.0, chance=chance)
    told = (1 / trust_in(simulation, found) - 1) * found.expected / np.where(variance > 0, variance, np.nan)
    each = np.nanmean(told, axis=(1, 2))
    assert each[[5, 17]] == pytest.approx(20, rel=0.35)
    assert np.delete(each, [5, 17]) == pytest.approx(1, abs=0.6)
    wide = norm.logpdf(simulation.counts, found.expected, np.sqrt(found.expected + chance[:, None, None] * variance))
    narrow = norm.logpdf(simulation.counts, found.expected, np.sqrt(found.expected))
    gained = on_others(simulation, found)[1] - marginal_deviance(simulation, found)
    # A variance of k times the mean is as rare as 1/k².
    assert gained == pytest.approx(2 * (wide - narrow).sum() - 2 * 4 * np.log(20), rel=0.05)


def test_counts_that_scatter_as_photons_do_are_trusted(uncertain):
    simulation, found, _ = uncertain(0.0)
    assert trust_in(simulation, found) is None
    assert marginal_deviance(simulation, found) == on_others(simulation, found)[1]


def test_the_deviance_is_that_of_a_normal_law_as_wide(uncertain, monkeypatch):
    simulation, found, variance = uncertain(1.0)
    monkeypatch.setattr(unseen, "_more", lambda each, owned: owned)
    mean = found.expected
    wide, narrow = (
        -2 * norm.logpdf(simulation.counts, mean, np.sqrt(mean + more)).sum() for more in (variance, 0 * variance)
    )
    gained = on_others(simulation, found)[1] - marginal_deviance(simulation, found)
    assert gained == pytest.approx(narrow - wide, rel=0.02)


def test_frames_are_trusted_as_those_of_the_whole_are(uncertain):
    simulation, found, _ = uncertain(1.0)
    some = np.array([2, 3, 11])
    np.testing.assert_allclose(trust_in(simulation.of(some), found), trust_in(simulation, found)[some])


def test_a_count_trusted_by_half_tells_half(drawn):
    simulation = drawn(4)
    half = simulation.trusting(np.full(simulation.counts.shape, 0.5))
    one, other = fit_nominal(simulation), fit_nominal(half)
    assert other.gain == pytest.approx(one.gain, rel=1e-6)
    assert other.deviance == pytest.approx(one.deviance / 2)
    np.testing.assert_allclose(other.covariance, 2 * one.covariance, rtol=1e-3)
    np.testing.assert_allclose(half.recorded, simulation.counts)
    np.testing.assert_allclose(half.trusting(None).counts, simulation.counts)
    np.testing.assert_allclose(half.of(np.array([1, 5])).expected(80.0), simulation.expected(80.0)[[1, 5]] / 2)
    np.testing.assert_allclose(half.dark, np.broadcast_to(simulation.dark / 2, half.dark.shape))


def test_a_frame_that_was_taken_when_nobody_saw_the_scene_tells_nothing(drawn):
    """A LiDAR that is a whole frame behind saw before the first image what no image shows."""
    simulation = drawn(4)
    step_s = float(np.diff(simulation.light.time_s)[0])
    for lag, blind in ((-step_s, [0]), (step_s, [len(simulation.counts) - 1]), (-0.1 * step_s, [])):
        start = np.append(fit_nominal(simulation).x, LAG.beginning({"lag": lag}).at_start())
        trust = trust_in(simulation, fit(simulation, (LAG,), start, most_steps=0))
        dark = [] if trust is None else np.flatnonzero((trust == unseen.BLIND).all(axis=(1, 2))).tolist()
        assert dark == blind

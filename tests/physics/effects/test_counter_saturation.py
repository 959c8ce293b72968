"""Clipped Poisson counts: against the sum over their distribution, and against counts drawn and clipped."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.stats import poisson

from physics.effects.counter_saturation import effect
from physics.nominal import ForwardModel


def shown(mean, ceiling, lost=1.0):
    values = effect.at(ceiling=ceiling, lost=lost).values
    return effect.expected(values, SimpleNamespace(expected=np.asarray(mean, float)))


@given(mean=st.floats(0, 400), ceiling=st.integers(2, 400))
def test_it_is_the_sum_over_the_poisson_distribution(mean, ceiling):
    n = np.arange(800)
    assert shown(mean, ceiling) == pytest.approx(np.minimum(n, ceiling) @ poisson.pmf(n, mean), rel=1e-9, abs=1e-9)


def test_counts_drawn_and_clipped_agree():
    mean = np.array([0.5, 200, 250, 255, 260, 400])
    drawn = np.minimum(np.random.default_rng(3).poisson(mean, (200_000, 6)), 255)
    error = drawn.std(axis=0) / np.sqrt(200_000)
    assert (np.abs(drawn.mean(axis=0) - shown(mean, 255)) < 5 * error + 1e-6).all()


@given(mean=st.floats(0, 1e8), ceiling=st.floats(2, 1e7), lost=st.floats(0, 1))
@example(mean=33554435.0, ceiling=2.31, lost=0.0)
def test_never_above_the_ceiling_nor_above_what_came(mean, ceiling, lost):
    assert shown(mean, ceiling) <= ceiling * (1 + 1e-9)
    assert 0 <= shown(mean, ceiling, lost) <= mean * (1 + 1e-9)


@given(mean=st.floats(0, 900), full=st.floats(150, 600), order=st.floats(1.5, 8))
def test_one_that_slows_down_shows_what_the_sum_over_the_poisson_distribution_has(mean, full, order):
    """To second order of the scatter: what is left is of third, order squared over the count."""
    n = np.arange(1400.0)
    closed = n / (1 + (n / full) ** order) ** (1 / order) @ poisson.pmf(n, mean)
    values = effect.at(slowing=1 / full, order=order).values
    found = effect.expected(values, SimpleNamespace(expected=np.array([mean])))[0]
    assert found == pytest.approx(closed, abs=0.05 + 0.7 * order**2 / full)


def test_few_counts_are_not_touched():
    np.testing.assert_allclose(shown([0, 1, 10, 100], 65535), [0, 1, 10, 100], rtol=1e-12)


def test_a_counter_that_goes_on_counting_is_another_cause():
    assert effect.strained(effect.at(lost=0.3, ceiling=100).values, None)
    assert not effect.strained(effect.at(lost=0.9, ceiling=100).values, None)


def test_zones_may_have_counters_of_their_own(small):
    model, ceilings = ForwardModel(small.light, small.footprints, small.clock, 3.0), np.array([40.0, 60, 5000, 50])
    found = model.expected(1e3, [effect.at(ceiling=ceilings)])
    for zone, ceiling in enumerate(ceilings):
        alone = model.expected(1e3, [effect.at(ceiling=ceiling)])
        np.testing.assert_allclose(found[:, zone], alone[:, zone])


def test_the_zone_that_stops_is_seen():
    """Zones whose pulses grow, one of which is clipped: its ceiling is its largest count; of one that has not reached
    it, too; others have none.
    """
    rng = np.random.default_rng(5)
    bright = np.array([1, 0.7, 0.9, 0.2])[:, None]
    mean = np.linspace(50, 900, 40)[:, None, None] * bright * np.exp(-np.arange(12) / 4.0)
    counts = rng.poisson(mean).astype(float)
    counts[:, 1] = np.minimum(counts[:, 1], 300)
    found = effect.starts(counts - mean, mean, None)[-1]
    assert found["lost"] == 1
    np.testing.assert_array_equal(found["ceiling"] < 1e6, [False, True, False, True])
    np.testing.assert_array_equal(found["ceiling"][[1, 3]], 300)
    counts[:, 2] = np.minimum(counts[:, 2], 500)  # One more that stops elsewhere: nobody knows of the others.
    found = effect.starts(counts - mean, mean, None)[-1]
    np.testing.assert_array_equal(found["ceiling"], [2**32, 300, 500, 2**32])
    plain = rng.poisson(mean)
    assert all(np.ndim(start.get("ceiling", 0)) == 0 for start in effect.starts(plain - mean, mean, None))

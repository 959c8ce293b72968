"""Counts that a clock moves stay counts, and slopes are those of what is made."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize
from scipy.stats import poisson

from mismatch.noise import Nuisances
from mismatch.settled import changed

COUNTS = st.floats(1e-3, 1e6)
PARTS = st.floats(-1e3, 1e3)


def mean_of(expected, change):
    """Written out cell by cell."""
    return expected + change if change >= -expected / 2 else expected**2 / (-4 * change)


@given(COUNTS, PARTS)
def test_counts_stay_positive_and_slopes_are_those_of_differences(expected, part):
    change = part * expected
    now = changed(np.array([expected]), np.array([change]), np.zeros(1))
    assert now.mean[0] == pytest.approx(mean_of(expected, change), rel=1e-9)
    assert now.mean[0] > 0
    step = 1e-5 * expected
    by_clock = (mean_of(expected, change + step) - mean_of(expected, change - step)) / (2 * step)
    by_expected = (mean_of(expected + step, change) - mean_of(expected - step, change)) / (2 * step)
    assert now.by_clock[0] == pytest.approx(by_clock, rel=1e-3, abs=1e-4)
    assert now.by_expected[0] == pytest.approx(by_expected, rel=1e-3, abs=1e-4)


def test_a_cell_of_nothing_stays_as_it_is():
    now = changed(np.zeros(2), np.array([0.0, -1.0]), np.zeros(1))
    np.testing.assert_array_equal(now.mean, 0)


@pytest.fixture
def missing(drawn, rig):
    """A simulation much of whose light was never there: a clock that takes away more than cells have."""
    simulation = drawn(2)
    expected = simulation.expected(rig.gain)
    tail = np.cumsum(expected, axis=2) > 0.7 * expected.sum(axis=2, keepdims=True)
    ways = np.stack([np.where(tail, -0.4 * expected, 0.1 * expected), np.where(tail, -5.0, 0.0) + 0 * expected])
    counts = np.random.default_rng(3).poisson(np.where(tail, 0.2 * expected, 1.15 * expected)).astype(float)
    return replace(simulation, counts=counts, loose=ways), expected


@pytest.mark.parametrize("before", [1.0, 1.5, 0.6])
def test_the_clock_settles_where_cells_are_emptied(missing, before):
    """Against scipy's least; from wherever models that came before had left it."""
    simulation, expected = missing
    counts = simulation.counts

    def loss(b):
        mean = np.vectorize(mean_of)(expected, np.tensordot(b, simulation.loose, 1))
        saturated, there = poisson.logpmf(counts, counts), poisson.logpmf(counts, np.maximum(mean, 1e-3))
        return 2 * (saturated - there).sum() + b @ b

    best = minimize(loss, np.zeros(2), method="Nelder-Mead", options={"xatol": 1e-4, "fatol": 1e-3})
    nuisances = Nuisances(simulation, 0.0)
    nuisances.deviance(before * expected)
    assert nuisances.deviance(expected) == pytest.approx(best.fun, abs=0.1)
    assert nuisances.applied(expected).min() >= 0


def test_a_model_is_judged_alike_whatever_came_before(missing):
    simulation, expected = missing
    fresh = Nuisances(simulation, 0.02).deviance(expected)
    after = Nuisances(simulation, 0.02)
    for factor in (0.5, 2.0, 1.1):
        after.deviance(factor * expected)
    assert after.deviance(expected) == pytest.approx(fresh, abs=0.05)


def test_those_that_follow_begin_where_the_clock_was(missing, monkeypatch):
    """They come to the same, and the information of the clock is not asked for again."""
    simulation, expected = missing
    first = Nuisances(simulation, 0.02)
    reached = first.deviance(expected)
    asked, inverse = [], Nuisances._inverse

    def counted(self, now):
        asked.append(now)
        return inverse(self, now)

    monkeypatch.setattr(Nuisances, "_inverse", counted)
    assert Nuisances(simulation, 0.02).deviance(expected) == pytest.approx(reached, abs=0.05)
    assert asked
    asked.clear()
    first.remember()
    assert Nuisances(simulation, 0.02).deviance(expected) == pytest.approx(reached, abs=0.05)
    assert not asked


def test_before_anything_was_asked_there_is_nothing_to_remember(missing):
    simulation, _ = missing
    Nuisances(simulation, 0.0).remember()
    assert simulation.remembered.clock is None

from itertools import permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from calibrate.adaptive_choice import best_cells, short_order


def covariance_of(rng, n):
    a = rng.normal(size=(n, n))
    return a @ a.T / n + 0.01 * np.eye(n)


@given(st.integers(0, 2**32 - 1))
def test_each_choice_leaves_the_least_error(seed):
    rng = np.random.default_rng(seed)
    covariance, cost, noise = covariance_of(rng, 8), rng.random(8) + 0.1, rng.random(8) * 0.1 + 0.01
    found = best_cells(covariance, np.arange(8), cost, noise, 3)

    def left(measured):
        """Cost after measuring, by Bayes' rule in terms of precisions; what was measured is as the full map has it."""
        precision = np.linalg.inv(covariance)
        for j in measured:
            precision[j, j] += 1 / noise[j]
        error = np.diag(np.linalg.inv(precision)) + noise
        error[list(measured)] = 0
        return cost @ error

    for i in range(3):
        others = [left([*found[:i], j]) for j in range(8) if j not in found[:i]]
        assert left(found[: i + 1]) == pytest.approx(min(others), rel=1e-9)


def test_a_cell_counts_with_all_its_zones():
    # Two zones look at cell 7, each telling less than the one that looks at cell 3 alone.
    covariance = np.diag([1.0, 0.8, 0.8])
    assert best_cells(covariance, np.array([3, 7, 7]), np.ones(3), np.full(3, 0.01), 2).tolist() == [7, 3]


def test_no_more_cells_than_there_are():
    found = best_cells(np.eye(3), np.array([0, 1, 2]), np.ones(3), np.ones(3), 9)
    assert sorted(found.tolist()) == [0, 1, 2]


def length(xy):
    return np.linalg.norm(np.diff(xy, axis=0), axis=1).sum()


@given(st.integers(0, 2**32 - 1), st.integers(0, 7))
def test_travel_is_nearly_the_shortest(seed, n):
    xy = np.random.default_rng(seed).random((n, 2))
    order = short_order(xy)
    assert sorted(order.tolist()) == list(range(n))
    if 2 < n < 7:
        begin = order[0]
        rest = [i for i in range(n) if i != begin]
        shortest = min(length(xy[[begin, *tour]]) for tour in permutations(rest))
        assert length(xy[order]) <= 1.5 * shortest


def test_a_row_is_run_through_once():
    xy = np.array([[3.0, 0], [0, 0], [4, 0], [1, 0], [2, 0]])
    assert short_order(xy).tolist() == [1, 3, 4, 0, 2]

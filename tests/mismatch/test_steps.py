"""Steps within bounds against the best of all, and large systems against plain elimination."""

import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from mismatch.steps import MANY, bounded_step, solved


@pytest.mark.parametrize("dense", [0, 40])
@pytest.mark.parametrize("many", [3, MANY + 30])
def test_a_solution_is_that_of_plain_elimination(many, dense):
    """Numbers of neighbouring edges, beside a few that all go along with; and with what gains of frames take."""
    rng = np.random.default_rng(many + dense)
    matrix = 3 * np.eye(many) - np.eye(many, k=1) - np.eye(many, k=-1)
    few = rng.normal(size=(2, many)) / many
    matrix[:2] += few
    matrix[:, :2] += few.T
    shared = rng.normal(size=(many, dense)) / 10
    matrix += shared @ shared.T
    right = rng.normal(size=many)
    np.testing.assert_allclose(solved(matrix, right), np.linalg.solve(matrix, right), atol=1e-10)


def test_what_is_positive_but_for_rounding_is_solved_without_a_word():
    rows = np.random.default_rng(1).normal(size=(MANY + 30, 20))
    matrix = rows @ rows.T - 1e-13 * np.eye(MANY + 30)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert np.isfinite(solved(matrix, rows[:, 0])).all()


@given(st.integers(0, 10_000), st.integers(1, 8))
def test_coordinates_that_a_bound_pulls_out_stay_and_others_are_best_beside_them(seed, many):
    """No slope is left in those that move, and none goes beyond a bound; where all move it is the best of all."""
    rng = np.random.default_rng(seed)
    root, aim = rng.normal(size=(40, many)), rng.normal(size=40)
    at = rng.random(many) < 0.5
    low, high = np.where(at, 0.0, -np.inf), np.full(many, np.inf)
    step = bounded_step(root.T @ aim, root.T @ root, 0.0, np.zeros(many), low, high)
    moved = ~at | (step != 0)
    assert (step[at] >= 0).all()
    np.testing.assert_allclose((root.T @ (aim - root @ step))[moved], 0, atol=1e-5)
    best = lsq_linear(root, aim, (low, high), tol=1e-12).x
    if moved.all():
        np.testing.assert_allclose(step, best, atol=1e-5)

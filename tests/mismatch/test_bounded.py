"""Least squares within bounds against all points of a grid, and against scipy's."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from mismatch.bounded import bounded_least_squares


def test_bounded_least_squares_is_the_best_on_a_grid():
    matrix, right = np.array([[2.0, 0.9], [0.9, 1.0]]), np.array([1.0, -0.6])
    low, high = np.array([0.0, -0.5]), np.array([2.0, 3.0])
    found = bounded_least_squares(matrix, right, low, high, np.zeros(2))
    axes = [np.linspace(a, b, 701) for a, b in zip(low, high, strict=True)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    value = 2 * grid @ right - np.einsum("...i,ij,...j->...", grid, matrix, grid)
    np.testing.assert_allclose(found, grid.reshape(-1, 2)[value.argmax()], atol=0.005)


@given(st.integers(0, 10_000), st.integers(1, 12))
def test_it_is_what_scipy_finds(seed, many):
    rng = np.random.default_rng(seed)
    root, aim = rng.normal(size=(30, many)), rng.normal(size=30)
    low, high = -rng.uniform(0, 0.3, many), rng.uniform(0, 0.3, many)
    found = bounded_least_squares(root.T @ root, root.T @ aim, low, high, np.zeros(many))
    np.testing.assert_allclose(found, lsq_linear(root, aim, (low, high), tol=1e-12).x, atol=1e-4)


def test_what_tells_nothing_stays_where_it_is():
    found = bounded_least_squares(
        np.diag([2.0, 0.0]), np.ones(2), np.full(2, -9.0), np.full(2, 9.0), np.array([0, 3.0])
    )
    np.testing.assert_allclose(found, [0.5, 3])

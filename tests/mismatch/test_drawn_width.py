"""The likeliest width of numbers that are drawn, against eigenvectors and a normal density written out."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import multivariate_normal

from mismatch.drawn_width import likeliest_width, tridiagonal


def told(size, seed, scale=1.0):
    rng = np.random.default_rng(seed)
    mixed = scale * rng.normal(size=(size, 2 * size))
    return mixed @ mixed.T, rng


@given(size=st.integers(1, 12), seed=st.integers(0, 1000))
def test_a_turned_matrix_is_the_same_in_other_directions(size, seed):
    matrix, rng = told(size, seed)
    vector = rng.normal(size=size)
    diagonal, beside, turned = tridiagonal(matrix, vector)
    dense = np.diag(diagonal) + np.diag(beside, 1) + np.diag(beside, -1)
    for power in range(4):
        kept, found = (v @ np.linalg.matrix_power(m, power) @ v for m, v in ((matrix, vector), (dense, turned)))
        assert found == pytest.approx(kept, rel=1e-9)
    np.testing.assert_allclose(np.linalg.eigvalsh(dense), np.linalg.eigvalsh(matrix), rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("size", [1, 2, 30])
def test_no_other_width_is_likelier(size):
    information, rng = told(size, size, 20.0)
    spread = np.linalg.inv(information)
    best = rng.multivariate_normal(np.zeros(size), spread + 0.1**2 * np.eye(size))
    loss, square, each = likeliest_width(information, information @ best)

    def unlikely(square):
        return -2 * multivariate_normal(np.zeros(size), spread + square * np.eye(size)).logpdf(best)

    assert unlikely(square) <= min(unlikely(1.05 * square), unlikely(square / 1.05)) + 1e-6
    # Up to a constant: what there is without a width at all.
    assert loss == pytest.approx(unlikely(square) - unlikely(0.0), rel=1e-6, abs=1e-6)
    np.testing.assert_allclose(each, np.linalg.eigvalsh(information), rtol=1e-9)


def test_directions_that_nothing_tells_do_no_harm():
    """An information that rounding has made less than nothing in some of them."""
    information, rng = told(20, 3)
    values, ways = np.linalg.eigh(information)
    values[:5] = -1e-13 * values.max()
    blind = (ways * values) @ ways.T
    score = blind @ rng.normal(size=20)
    loss, square, each = likeliest_width(blind, score)
    assert np.isfinite([loss, square]).all()
    assert each.min() == 0

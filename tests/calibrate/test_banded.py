import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import sparse
from scipy.stats import multivariate_normal

from calibrate.banded import RIDGE, banded, solve
from calibrate.spline import SplineBasis


def problem(seed, points=60, zones=2):
    rng = np.random.default_rng(seed)
    basis = SplineBasis(0, 0, 2.0, 6, 4)
    x, y = rng.uniform(0, 12, points), rng.uniform(0, 8, points)
    design = basis.at(x, y)
    truth = np.stack([np.sin(x / 2 + p) * np.cos(y / 3) for p in range(zones)])
    return design, basis.roughness(), truth + 0.1 * rng.standard_normal(truth.shape)


@given(st.integers(0, 2**32 - 1))
def test_agrees_with_dense_algebra(seed):
    design, penalty, y = problem(seed)
    found = solve(design, penalty, y)
    a = design.toarray()
    q = penalty.toarray() + RIDGE * np.eye(penalty.shape[0])
    inverse = np.linalg.inv(a.T @ a + found.smoothness * q)
    np.testing.assert_allclose(found.coefficients(y), (inverse @ a.T @ y.T).T, atol=1e-6)
    np.testing.assert_allclose(found.leverage, np.diag(a @ inverse @ a.T), atol=1e-8)


def test_replacing_a_datum_by_its_prediction_leaves_it_out():
    design, penalty, y = problem(3)
    found = solve(design, penalty, y)
    fitted = found.coefficients(y) @ design.T.toarray()
    left_out = y - (y - fitted) / (1 - found.leverage)
    a = design.toarray()
    q = found.smoothness * (penalty.toarray() + RIDGE * np.eye(penalty.shape[0]))
    for k in (0, 17, 59):
        others = np.arange(60) != k
        c = np.linalg.solve(a[others].T @ a[others] + q, a[others].T @ y[0, others])
        assert a[k] @ c == pytest.approx(left_out[0, k], abs=1e-8)


def test_smoothness_has_the_largest_evidence():
    """Against the density of the data as one multivariate normal, with the best noise for each smoothness."""
    design, penalty, y = problem(5, zones=1)
    a, q = design.toarray(), penalty.toarray() + RIDGE * np.eye(penalty.shape[0])

    def evidence(smoothness):
        covariance = np.eye(60) + a @ np.linalg.inv(smoothness * q) @ a.T
        noise = y[0] @ np.linalg.solve(covariance, y[0]) / 60
        return multivariate_normal(cov=noise * covariance).logpdf(y[0])

    best = solve(design, penalty, y).smoothness
    assert evidence(best) > max(evidence(best * 1.5), evidence(best / 1.5))


def test_banded_storage():
    rng = np.random.default_rng(0)
    dense = np.triu(np.tril(rng.normal(size=(6, 6)), 2), -2)
    dense = dense + dense.T
    stored = banded(sparse.csr_array(dense))
    assert stored.shape == (3, 6)
    for offset in range(3):
        np.testing.assert_array_equal(stored[offset, : 6 - offset], np.diag(dense, -offset))

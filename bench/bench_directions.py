"""Directions that a fit takes out of whitened counts: by products of columns, beside two decompositions of LAPACK."""

import time

import numpy as np
import pytest
from scipy.linalg import qr
from threadpoolctl import threadpool_limits

from mismatch.directions import SAME, orthonormal


def by_svd(columns):
    """numpy's singular value decomposition."""
    left, size, _ = np.linalg.svd(columns, full_matrices=False)
    return left[:, size > SAME * size.max()]


def by_qr(columns):
    """scipy's QR with columns exchanged."""
    q, r, _ = qr(columns, mode="economic", pivoting=True, check_finite=False)
    size = np.abs(np.diag(r))
    return q[:, size > SAME * size.max()]


@pytest.mark.parametrize("many", [10, 60])
def test_directions(many):
    """48 frames of 9 zones and 128 bins, and as many columns as an estimated clock has, two of which are alike."""
    columns = np.random.default_rng(3).normal(size=(48 * 9 * 128, many))
    columns[:, 1] = columns[:, 0] + 1e-9 * columns[:, 1]
    columns /= np.linalg.norm(columns, axis=0)
    taken, found = {}, {}
    with threadpool_limits(1, user_api="blas"):
        for _ in range(5):
            for way in (orthonormal, by_svd, by_qr):
                begin = time.perf_counter()
                found[way.__name__] = way(columns)
                taken.setdefault(way.__name__, []).append(time.perf_counter() - begin)
    median = {name: np.median(times[1:]) for name, times in taken.items()}
    print("\n" + ", ".join(f"{name} {1e3 * one:.0f} ms" for name, one in median.items()), f"of {many} columns")
    mine, theirs = found["orthonormal"], found["by_svd"]
    assert mine.shape == theirs.shape == (len(columns), many - 1)
    np.testing.assert_allclose(mine @ (mine.T @ theirs), theirs, atol=1e-9)
    assert median["orthonormal"] < median["by_svd"]

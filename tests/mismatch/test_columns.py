"""Sparse rows against the same rows written out."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_array, issparse

from mismatch.columns import by_frame, of_frames, product, rows_of, scaled, spread, together

SHAPE = (3, 2, 5)
COUNT = {"zone": 2, "bin": 5, "edge": 5, "zone bin": 10, "zone edge": 10}


def moved_by(axis, frame, zone, bin_, after):
    """Which coordinate a cell goes with, one by one."""
    at = bin_ + 1 if after else bin_
    if axis == "zone":
        return zone
    return at if axis in ("bin", "edge") else zone * SHAPE[2] + at


@pytest.mark.parametrize("axis", sorted(COUNT))
def test_each_cell_goes_with_its_own(axis):
    rng = np.random.default_rng(1)
    change, after = rng.normal(size=(2, *SHAPE))
    edges = "edge" in axis
    expected = np.zeros((COUNT[axis], *SHAPE))
    for cell in np.ndindex(SHAPE):
        expected[(moved_by(axis, *cell, False), *cell)] += change[cell]
        if edges and cell[2] + 1 < SHAPE[2]:
            expected[(moved_by(axis, *cell, True), *cell)] += after[cell]
    found = rows_of(axis, change, after if edges else None)
    np.testing.assert_array_equal(found.toarray(), expected.reshape(COUNT[axis], -1))


@given(seed=st.integers(0, 999))
def test_what_is_done_to_rows_is_the_same_where_they_are_sparse(seed):
    rng = np.random.default_rng(seed)
    written = rng.normal(size=(7, 30)) * (rng.random((7, 30)) < 0.3)
    dense, factor, weights = rng.normal(size=(4, 30)), rng.normal(size=30), rng.normal(size=SHAPE)
    sparse = csr_array(written)
    np.testing.assert_allclose(scaled(sparse, factor).toarray(), scaled(written, factor))
    np.testing.assert_allclose(product(sparse, sparse), written @ written.T, atol=1e-12)
    np.testing.assert_allclose(product(sparse, dense), written @ dense.T, atol=1e-12)
    np.testing.assert_allclose(product(dense, sparse), dense @ written.T, atol=1e-12)
    summed = (written * weights.ravel()).reshape(7, 3, 10).sum(axis=2)
    for rows in (sparse, written):
        np.testing.assert_allclose(by_frame(rows, weights), summed, atol=1e-12)
    chosen = np.array([2, 0])
    np.testing.assert_allclose(of_frames(sparse, 3, chosen).toarray(), of_frames(written, 3, chosen))
    np.testing.assert_allclose(
        of_frames(written, 3, chosen), written.reshape(7, *SHAPE)[:, chosen].reshape(7, -1), atol=0
    )
    both = together(sparse, dense)
    assert issparse(both)
    np.testing.assert_allclose(both.toarray(), together(written, dense))
    assert together(sparse, dense[:0]) is sparse
    where = rng.permutation(9)[:7]
    found = spread(sparse, where, 9, np.arange(7.0)).toarray()
    np.testing.assert_allclose(found[where], written * np.arange(7.0)[:, None])
    assert not np.delete(found, where, axis=0).any()

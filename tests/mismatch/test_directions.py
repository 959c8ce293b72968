"""What a fit can make: directions known by their information against the same written out, and both against algebra."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_array

from mismatch.directions import Directions, Frames, orthonormal

SHAPE = (4, 2, 6)
CELLS = 48


@pytest.fixture(params=[None, 0.05, 3.0])
def made(request):
    rng = np.random.default_rng(3)
    rows = rng.normal(size=(9, CELLS)) * (rng.random((9, CELLS)) < 0.4)
    rows[7] = 2 * rows[0] - rows[3]  # Of what others can make, too.
    rows[8] = 0
    rows *= 10.0 ** rng.integers(-3, 4, 9)[:, None]
    frames = None if request.param is None else Frames(rng.uniform(1, 5, SHAPE), request.param)
    return rows, frames


def operator(frames):
    """(C, C) that takes frames' gains out of whitened counts: the root of what is left of the noise's covariance."""
    out = np.eye(CELLS)
    if frames is None:
        return out
    for f in range(SHAPE[0]):
        signal = np.zeros(SHAPE)
        signal[f] = frames.signal[f]
        signal = signal.ravel()
        out -= np.outer(signal, signal) / frames.norm[f] ** 2
    values, ways = np.linalg.eigh(out)
    return ways @ np.diag(np.sqrt(np.maximum(values, 0))) @ ways.T


def test_gains_of_frames_are_taken_as_their_prior_has_it(made):
    _, frames = made
    if frames is None:
        return
    white = np.random.default_rng(4).normal(size=(CELLS, 3))
    np.testing.assert_allclose(frames.out(white), operator(frames) @ white, atol=1e-10)


@pytest.mark.parametrize("kind", [np.asarray, csr_array])
def test_directions_are_those_of_the_rows(made, kind):
    rows, frames = made
    found, root = Directions(kind(rows), frames), operator(frames)
    size = np.linalg.norm(rows @ root, axis=1)
    u, s, _ = np.linalg.svd((rows[size > 1e-12] / size[size > 1e-12, None] @ root).T, full_matrices=False)
    u = u[:, s > 1e-6]
    white, others = np.random.default_rng(5).normal(size=(2, CELLS, 3))
    np.testing.assert_allclose(found.out(white), white - u @ (u.T @ white), atol=1e-9)
    for mine, oracle in ((found.products(others.T), others.T @ u), (found.taken(others.T), others.T @ root @ u)):
        # Orthonormal directions are what they are up to a rotation.
        np.testing.assert_allclose(mine @ mine.T, oracle @ oracle.T, atol=1e-8)
    sparse = csr_array(others.T * (np.abs(others.T) > 1))
    np.testing.assert_allclose(found.products(sparse), found.products(sparse.toarray()), atol=1e-9)
    np.testing.assert_allclose(found.taken(sparse), found.taken(sparse.toarray()), atol=1e-9)
    assert (found.written is None) == (kind is csr_array)


@given(st.integers(0, 1000), st.floats(-9, -1))
def test_columns_that_are_nearly_others_count_or_do_not_and_never_spoil_the_rest(seed, apart):
    """As a singular value decomposition has them; at the border either is right."""
    columns = np.random.default_rng(seed).normal(size=(CELLS, 6))
    columns[:, 4] = columns[:, 0] - columns[:, 1] + 10**apart * columns[:, 4]
    columns /= np.linalg.norm(columns, axis=0)
    found = orthonormal(columns)
    u, s, _ = np.linalg.svd(columns, full_matrices=False)
    u = u[:, : found.shape[1]]
    np.testing.assert_allclose(found.T @ found, np.eye(found.shape[1]), atol=1e-12)
    np.testing.assert_allclose(found @ (found.T @ u), u, atol=1e-8)
    clear = (s > 2e-6 * s[0]).sum(), (s > 5e-7 * s[0]).sum()
    assert clear[0] <= found.shape[1] <= clear[1]


def test_of_no_columns_there_are_no_directions():
    assert orthonormal(np.zeros((CELLS, 0))).shape == (CELLS, 0)

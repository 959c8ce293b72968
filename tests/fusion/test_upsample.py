"""Bringing coarse images to the camera's grid."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from fusion.upsample import upsample, upsample_guided


def test_a_plane_stays_a_plane():
    v, u = np.mgrid[:6, :8] * 8 + 3.5
    large = upsample(0.01 * u + 0.02 * v, (48, 64))
    rows, columns = np.mgrid[8:40, 8:56]
    np.testing.assert_allclose(large[8:40, 8:56], 0.01 * columns + 0.02 * rows, atol=1e-4)


def test_an_edge_of_depth_goes_where_the_edge_of_grey_is():
    rgb = np.zeros((48, 64, 3), np.uint8)
    rgb[:, 35:] = 200
    coarse = np.where(np.arange(8) < 4, 1.0, 2.0) * np.ones((6, 1))
    coarse[:, 4] = 1 + 5 / 8
    guided, plain = upsample_guided(coarse, rgb), upsample(coarse, (48, 64))
    truth = np.where(np.arange(64) < 35, 1.0, 2.0)
    assert np.abs(guided - truth).mean() < 0.6 * np.abs(plain - truth).mean()


@given(st.integers(0, 999))
def test_stays_between_least_and_largest(seed):
    rng = np.random.default_rng(seed)
    coarse = rng.uniform(1, 3, (4, 5))
    large = upsample_guided(coarse, rng.integers(0, 255, (32, 40, 3)).astype(np.uint8))
    assert large.shape == (32, 40)
    assert large.min() >= coarse.min() - 1e-6
    assert large.max() <= coarse.max() + 1e-6

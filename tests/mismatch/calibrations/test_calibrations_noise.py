import numpy as np
import pytest

from mismatch.calibrations.noise import local_scatter


def grid():
    xs, ys = np.meshgrid(np.arange(40) * 10.0, np.arange(30) * 10.0)
    return np.stack([xs.ravel(), ys.ravel()], axis=1)


def test_white_noise_on_a_plane_is_measured():
    xy, rng = grid(), np.random.default_rng(4)
    values = 500 + 2 * xy[:, 0] - xy[:, 1] + 7.0 * rng.standard_normal((2, len(xy)))
    scatter = local_scatter(xy, values)
    assert scatter.shape == values.shape
    assert np.median(scatter) == pytest.approx(7.0, rel=0.15)


def test_noise_that_grows_with_brightness_grows():
    xy, rng = grid(), np.random.default_rng(5)
    clean = 100 + 10 * xy[:, 0]
    scatter = local_scatter(xy, (clean * (1 + 0.05 * rng.standard_normal(len(xy))))[None])[0]
    bright = clean > 3000
    assert np.median(scatter[bright] / (0.05 * clean[bright])) == pytest.approx(1, rel=0.25)
    assert np.median(scatter[clean < 500]) < 60


def test_one_wild_sample_does_not_move_it():
    xy, rng = grid(), np.random.default_rng(6)
    values = 500 + 7.0 * rng.standard_normal((1, len(xy)))
    values[0, 600] = 1e6
    assert np.median(local_scatter(xy, values)) == pytest.approx(7.0, rel=0.25)

"""The bench's geometry against OpenCV's camera model and rigid motion by hand."""

import cv2
import numpy as np
import pytest

from calibrate.plan import ScanPlan
from calibrate.simulated.bench import Bench
from recordings.refusal import Refusal

PLAN = ScanPlan(80, 45)


def positions(bench=None, seed=0):
    return (bench or Bench()).patch_positions(PLAN, np.random.default_rng(seed))


def test_projection_is_a_camera_with_one_radial_coefficient():
    bench, points = Bench(), positions()
    distortion = np.array([bench.distortion, 0, 0, 0])
    expected, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), bench.intrinsics, distortion)
    assert bench.project(points) == pytest.approx(expected[:, 0], abs=1e-6)


def test_grid_lies_as_the_published_one_does():
    """Centres from the lower left corner, 10 by 10 px apart, a few partly outside; narrower on the right."""
    bench = Bench()
    x, y = bench.project(positions()).T.reshape(2, 45, 80)
    x[1::2], y[1::2] = x[1::2, ::-1], y[1::2, ::-1]
    assert 0 < x.min() < 10
    assert 815 < x.max() < 840
    assert 0 < y.min() < 15
    assert 455 < y.max() < 480
    assert np.median(np.diff(x, axis=1)) == pytest.approx(10.3, abs=0.5)
    assert np.median(np.diff(y, axis=0)) == pytest.approx(-9.9, abs=0.5)
    left, right = np.ptp(y[:, 0]), np.ptp(y[:, -1])
    assert 0.88 < right / left < 0.97


def test_patch_radius_is_the_published_one():
    radius = Bench().focal_px * Bench().patch_radius_m / positions()[:, 2]
    assert np.median(radius) == pytest.approx(17.75, abs=0.1)


def test_jitter_is_the_only_thing_random():
    exact = positions(Bench(jitter_m=0))
    assert np.array_equal(exact, positions(Bench(jitter_m=0), seed=1))
    assert (positions() - exact).std(axis=0) == pytest.approx([1e-4] * 3, rel=0.1)


def test_lidar_frame_is_rigid_and_sits_at_the_lidar():
    bench = Bench(lidar_rotation_deg=(0, 0, 90), lidar_position_m=(0.1, 0.2, 0.3))
    assert bench.to_lidar(np.array([0.1, 0.2, 0.3])) == pytest.approx([0, 0, 0], abs=1e-12)
    # Turned by 90 degrees about z, the LiDAR's x axis points along the camera's y axis.
    assert bench.to_lidar(np.array([0.1, 1.2, 0.3])) == pytest.approx([1, 0, 0], abs=1e-12)


def test_another_range_covers_the_same_image():
    near, far = Bench(jitter_m=0), Bench(jitter_m=0).at_range(0.9)
    assert far.project(positions(far)) == pytest.approx(near.project(positions(near)), abs=1e-6)
    assert np.median(positions(far)[:, 2]) == pytest.approx(0.9, abs=0.01)


def test_a_grid_of_one_cell_is_in_the_middle():
    centre = Bench().project(Bench().patch_positions(ScanPlan(1, 1), np.random.default_rng(0)))
    assert centre[0] == pytest.approx([426, 240], abs=5)


@pytest.mark.parametrize("wrong", [{"patch_range_m": 0.0}, {"patch_radius_m": -1.0}, {"focal_px": np.nan}])
def test_impossible_benches_are_refused(wrong):
    with pytest.raises(Refusal, match="expected a positive number"):
        Bench(**wrong)


def test_a_patch_as_large_as_its_range_is_refused():
    with pytest.raises(Refusal, match="expected at most half the range"):
        Bench(patch_radius_m=0.5)

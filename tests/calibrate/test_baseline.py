import json

import numpy as np
import pytest

from calibrate.baseline import estimate_baseline
from recordings.maps import ResponseMaps
from recordings.refusal import Refusal

INTRINSICS = np.array([[612.0, 0, 424], [0, 612, 240], [0, 0, 1]])
ORIGIN = np.array([0.021, -0.007, 0.004])


def scan_at(depth, origin=ORIGIN, zones=4, noise=0.01, seed=0):
    """A patch of constant size scanned in a plane: zones are bells in angle about the LiDAR, falling with r⁻⁴."""
    rng = np.random.default_rng(seed)
    x, y = (g.ravel() for g in np.meshgrid(np.arange(150.0, 700, 14), np.arange(60.0, 420, 14)))
    point = depth * np.linalg.solve(INTRINSICS, np.stack([x, y, np.ones_like(x)])).T - origin
    r = np.linalg.norm(point, axis=1)
    u, v = point[:, 0] / point[:, 2], point[:, 1] / point[:, 2]
    middle = [(-0.12 + 0.24 * (p % 2), -0.09 + 0.18 * (p // 2)) for p in range(zones)]
    clean = np.stack([np.exp(-(((u - a) / 0.09) ** 4) - ((v - b) / 0.07) ** 4) / r**4 for a, b in middle])
    values = np.maximum(1e4 * clean * (1 + noise * rng.standard_normal(clean.shape)), 0)
    return ResponseMaps(
        values.reshape(2, -1, len(x)), x, y, np.array([f"{i:04d}" for i in range(len(x))]), json.dumps({})
    )


def test_finds_the_baseline_within_its_error():
    near, far = scan_at(0.35, seed=1), scan_at(1.1, seed=2)
    found = estimate_baseline(near, far, INTRINSICS, (0.35, 1.1), (0.0, 0.0))
    np.testing.assert_allclose(found.origin_m[:2], ORIGIN[:2], atol=4e-4)
    assert abs(found.origin_m[2] - ORIGIN[2]) < 3e-3
    assert (np.abs(found.origin_m - ORIGIN) < 4 * found.sigma_m + 1e-4).all()
    assert found.rms < 0.05
    np.testing.assert_allclose(found.lidar_from_camera[:3, 3], -found.origin_m)


def test_equal_ranges_show_no_parallax():
    with pytest.raises(Refusal, match="factor"):
        estimate_baseline(scan_at(0.5), scan_at(0.51), INTRINSICS, (0.5, 0.51), (0.0, 0.0))


@pytest.mark.parametrize("depths", [(0.0, 1.0), (-1.0, 1.0), (np.nan, 1.0)])
def test_impossible_distances_are_refused(depths):
    with pytest.raises(Refusal, match="above 0"):
        estimate_baseline(scan_at(0.5), scan_at(0.6), INTRINSICS, depths, (0.0, 0.0))

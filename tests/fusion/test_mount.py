"""The mount's parallax against where points of known depth fall in two pinhole cameras."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from fusion.mount import baseline, mounted
from fusion.sight import sight
from physics.effects import find_effect
from physics.presets import preset
from recordings.maps import ResponseMaps
from recordings.refusal import Refusal

INTRINSICS = np.array([[600.0, 0, 423.5], [0, 600, 239.5], [0, 0, 1]])


def mount(place, turn=(0, 0, 0)):
    there = np.eye(4)
    there[:3, :3] = Rotation.from_rotvec(turn).as_matrix()
    there[:3, 3] = -there[:3, :3] @ place
    return there


def maps(**meta):
    x, y = (a.ravel().astype(float) for a in np.meshgrid(np.arange(0, 848, 40), np.arange(0, 480, 40)))
    bell = np.exp(-((x - 424) ** 2 + (y - 240) ** 2) / 2 / 60**2)
    return ResponseMaps(bell[None, None], x, y, np.full(len(x), "a"), json.dumps(meta))


def test_the_baseline_is_the_origin_that_the_transform_takes_to_zero():
    place = np.array([0.012, -0.03, 0.004])
    there = mount(place, (0.1, -0.2, 0.05))
    np.testing.assert_allclose(there @ np.append(baseline(maps(), there), 1), [0, 0, 0, 1], atol=1e-12)
    np.testing.assert_allclose(baseline(maps(lidar_from_camera=there.tolist())), place, atol=1e-12)
    np.testing.assert_array_equal(baseline(maps()), 0)
    with pytest.raises(Refusal, match=r"shape \(3, 3\), expected a rigid"):
        baseline(maps(), np.eye(3))


def test_the_sensor_moves_footprints_as_the_sight_does():
    """A line of sight of the LiDAR, through a point at the calibration's depth, meets other depths beside it."""
    place, known = np.array([0.02, 0.01, 0.0]), 0.6
    seen = maps(lidar_from_camera=mount(place).tolist(), calibration_range_m=known)
    sensor = preset("tmf8828-3x3-wide-long")
    (parallax,) = mounted(sensor, seen).effects
    assert (parallax.values["x"], parallax.values["y"]) == pytest.approx(place[:2])
    where = sight(seen, (480, 848), INTRINSICS)
    at = np.array([0.05, 0.02, 1.0]) * known
    beyond = place + (at - place) * 3
    pixels = [(INTRINSICS @ point / point[2])[:2] for point in (at, beyond)]
    length = float((where.weights[0] * where.ray_length).sum() / where.weights[0].sum())
    np.testing.assert_allclose(where.shift_px(np.array([beyond[2] * length]))[0], pixels[1] - pixels[0], rtol=2e-2)


def test_what_the_sensor_has_already_is_added():
    sensor = preset("tmf8828-3x3-wide-long")
    assert mounted(sensor, maps()) is sensor
    own = replace(sensor, effects=(find_effect("parallax").at(x=0.01, y=0.0),))
    (found,) = mounted(own, maps(), mount((0.02, -0.005, 0))).effects
    assert (found.values["x"], found.values["y"]) == pytest.approx((0.03, -0.005))

"""How far a camera came, by what it saw, against cameras whose way is known."""

import numpy as np
import pytest

from physics.approach import approached_m
from physics.light import direct_light

SHAPE = (24, 32)
INTRINSICS = np.array([[30.0, 0, 15.5], [0, 30, 11.5], [0, 0, 1]])


def planes(ways, normals, distances):
    """(F, H, W) depth of the nearest of planes n·X = d along each ray, for a camera that has moved ahead."""
    v, u = np.indices(SHAPE)
    ray = np.stack([(u - 15.5) / 30, (v - 11.5) / 30, np.ones(SHAPE)], -1)
    found = []
    for way in ways:
        with np.errstate(divide="ignore"):
            each = [(d - n[2] * way) / (ray @ n) for n, d in zip(np.asarray(normals, float), distances, strict=True)]
        found.append(np.min([np.where(z > 0, z, np.inf) for z in each], axis=0))
    return np.array(found)


WAYS = np.array([0.0, 0.1, 0.25, 0.2])


@pytest.mark.parametrize(
    ("normals", "distances"),
    [
        ([(0, 0, 1)], [2.0]),
        ([(0.3, -0.2, 1)], [1.7]),
        # A corridor, most of which does not come nearer as one walks along it.
        ([(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1)], [0.6, 0.6, 0.5, 0.5, 2.5]),
    ],
)
def test_the_way_of_a_camera_before_walls(normals, distances):
    light = direct_light(planes(WAYS, normals, distances), INTRINSICS, time_s=np.arange(4.0))
    np.testing.assert_allclose(approached_m(light), WAYS, atol=5e-3)


def test_what_moves_in_less_than_half_of_the_view_does_not_count():
    depth = planes(WAYS, [(0, 0, 1)], [2.0])
    depth[:, 4:16, 4:18] = (0.9 + np.array([0.0, 0.1, 0.3, 0.5]))[:, None, None]
    light = direct_light(depth, INTRINSICS, time_s=np.arange(4.0))
    np.testing.assert_allclose(approached_m(light), WAYS, atol=1e-3)


def test_frames_of_a_session_keep_what_all_of_it_says():
    depth = planes(WAYS, [(0, 0, 1)], [2.0])
    light = direct_light(depth, INTRINSICS, time_s=np.arange(4.0))
    np.testing.assert_allclose(approached_m(light.of(np.array([1, 3]))), WAYS[[1, 3]], atol=1e-3)


def test_where_nothing_is_known_nothing_moved():
    light = direct_light(np.full((3, *SHAPE), np.nan), INTRINSICS, time_s=np.arange(3.0))
    assert not approached_m(light).any()

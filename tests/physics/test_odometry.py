"""The way of a camera by what it sees, against ways that are known."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from physics.light import direct_light
from physics.motion import Motion
from physics.odometry import apparent_motion, moved_m

SHAPE = (40, 60)
INTRINSICS = np.array([[50.0, 0, 29.5], [0, 50, 19.5], [0, 0, 1]])
RAYS = np.stack([*np.meshgrid((np.arange(60) - 29.5) / 50, (np.arange(40) - 19.5) / 50), np.ones(SHAPE)], axis=-1)
TIMES = np.linspace(0, 1, 9)
ROOM = [((1, 0, 0), 1.1), ((-1, 0, 0.1), 1.3), ((0, 1, 0), 0.7), ((0.2, -1, 0), 0.9), ((0.2, 0.1, 1), 2.5)]


def poses(times, moved=(0.15, -0.05, 0.4), turned=(0.1, 0.25, -0.1)):
    """World from a camera that sways."""
    out = np.tile(np.eye(4), (len(times), 1, 1))
    sway = np.sin(2 * np.asarray(times))[:, None]
    out[:, :3, :3] = Rotation.from_rotvec(sway * turned).as_matrix()
    out[:, :3, 3] = sway * moved
    return out


def depths(at, planes=ROOM):
    """(F, H, W) depth of the nearest of planes n·X = d along each ray."""
    found = []
    for pose in at:
        rays = RAYS @ pose[:3, :3].T
        each = []
        for normal, away in planes:
            n = np.array(normal) / np.linalg.norm(normal)
            with np.errstate(divide="ignore"):
                z = (away - n @ pose[:3, 3]) / (rays @ n)
            each.append(np.where(z > 0, z, np.inf))
        found.append(np.min(each, axis=0))
    return np.array(found)


def seen(depth, motion=None):
    return direct_light(depth, INTRINSICS, time_s=TIMES, motion=motion)


def test_the_way_through_a_room():
    true = poses(TIMES)
    found = apparent_motion(seen(depths(true))).start_from_camera
    np.testing.assert_allclose(found, true, atol=6e-3)


def test_what_is_known_of_the_way_is_bettered_but_kept_where_nothing_tells():
    """Before one wall only its distance and two tilts are seen: the rest stays as it was said to be."""
    true = poses(TIMES)
    said = true.copy()
    said[:, 2, 3] += 0.02 * TIMES
    found = apparent_motion(seen(depths(true, [((0, 0, 1), 2.0)]), Motion.of(TIMES, said))).start_from_camera
    np.testing.assert_allclose(found, true, atol=6e-3)


def test_where_most_stands_still_nothing_moves_whatever_passes():
    depth = depths(np.tile(np.eye(4), (9, 1, 1)))
    for i in range(9):
        depth[i, 10:30, 5 + 4 * i : 18 + 4 * i] = 0.6
    np.testing.assert_array_equal(apparent_motion(seen(depth)).start_from_camera, np.tile(np.eye(4), (9, 1, 1)))


def test_a_wall_that_nears_by_far_in_a_frame():
    way = np.zeros(9)
    way[1::2] = 0.9
    found = apparent_motion(seen(depths(np.tile(np.eye(4), (9, 1, 1)), [((0.1, 0, 1), 2.0)]) - way[:, None, None]))
    # Slides along the wall are not seen: by how much it is nearer along its normal.
    normal = np.array([0.1, 0, 1]) / np.hypot(0.1, 1)
    np.testing.assert_allclose(found.start_from_camera[:, :3, 3] @ normal, way * normal[2], atol=0.02)


@pytest.mark.parametrize("depth", [np.full((9, *SHAPE), np.nan), np.ones((9, *SHAPE))])
def test_where_nothing_is_told_nothing_moved(depth):
    np.testing.assert_array_equal(apparent_motion(seen(depth)).start_from_camera, np.tile(np.eye(4), (9, 1, 1)))


def test_some_frames_of_a_session_have_the_way_of_all():
    light = seen(depths(poses(TIMES)))
    assert apparent_motion(light.of(np.array([1, 5]))) is apparent_motion(light)


def test_where_it_has_gone_goes_by_what_was_recorded_or_else_by_what_is_seen():
    true = poses(TIMES)
    by_hand = [(np.linalg.inv(true[0]) @ pose)[:3, 3] for pose in true]
    np.testing.assert_allclose(moved_m(seen(depths(true), Motion.of(TIMES, true))), by_hand, atol=1e-12)
    np.testing.assert_allclose(moved_m(seen(depths(true))), by_hand, atol=0.02)

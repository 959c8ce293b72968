"""Which earlier view is taken."""

import numpy as np
import pytest

from fusion.motion import BEST, KEPT, Earlier, grey
from fusion.sight import Sight

SHAPE = (96, 128)
K = np.array([[100.0, 0, 63.5], [0, 100, 47.5], [0, 0, 1]])
WHERE = Sight(np.ones((1, *SHAPE), np.float32), K, (1, 1), np.zeros(3), np.inf)
RGB = np.random.default_rng(0).integers(0, 256, (*SHAPE, 3)).astype(np.uint8)


def at(x=0.0, turn_deg=0.0):
    pose, turn = np.eye(4), np.radians(turn_deg)
    pose[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
    pose[0, 3] = x
    return pose


def test_the_view_from_the_best_distance_is_taken():
    earlier = Earlier(WHERE)
    for x in (0.0, 0.05, 0.1, 0.14):
        earlier.add(RGB, at(x), 2.0)
    found = earlier.motion(at(0.16), 2.0)
    assert np.linalg.norm(found.step[:3, 3]) == pytest.approx(BEST * 2.0)
    # The earlier camera was to the left: what is ahead lies to the right of it.
    assert found.step[0, 3] == pytest.approx(0.06)


@pytest.mark.parametrize("pose", [at(0.001), at(0.5), at(0.1, 20.0), None])
def test_too_near_too_far_turned_or_nowhere(pose):
    earlier = Earlier(WHERE)
    earlier.add(RGB, at(), 2.0)
    assert earlier.motion(pose, 2.0) is None


def test_nothing_is_known_of_the_range():
    earlier = Earlier(WHERE)
    earlier.add(RGB, at(), np.nan)
    assert earlier.motion(at(0.1), np.nan) is None


def test_views_without_image_or_pose_tell_nothing():
    earlier = Earlier(WHERE)
    earlier.add(None, at(), 2.0)
    earlier.add(RGB, None, 2.0)
    assert earlier.motion(at(0.1), 2.0) is None


def test_a_robot_that_stands_forgets_nothing_and_one_that_drives_on_stays_bounded():
    earlier = Earlier(WHERE)
    earlier.add(RGB, at(), 2.0)
    for _ in range(5 * KEPT):
        earlier.add(RGB, at(0.06), 2.0)
    assert np.linalg.norm(earlier.motion(at(0.06), 2.0).step[:3, 3]) == pytest.approx(0.06)
    for k in range(5 * KEPT):
        earlier.add(RGB, at(0.06 + 0.06 * k), 2.0)
    assert len(earlier._views) == KEPT


def test_a_buffer_that_the_camera_fills_again_changes_nothing():
    earlier, buffer = Earlier(WHERE), RGB.copy()
    earlier.add(buffer, at(), 2.0)
    buffer[:] = 0
    found = earlier.motion(at(0.06), 2.0)
    np.testing.assert_array_equal(found.grey, grey(RGB, found.grey.shape))

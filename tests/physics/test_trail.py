"""Surfaces that a moving camera sees, leaves and finds again: rooms and bars cast ray by ray from known places."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from physics.segments import segments

SHAPE = (36, 48)
INTRINSICS = np.array([[40.0, 0, 23.5], [0, 40.0, 17.5], [0, 0, 1]])
V, U = np.mgrid[: SHAPE[0], : SHAPE[1]]
RAYS = np.stack([(U - 23.5) / 40, (V - 17.5) / 40, np.ones(SHAPE)], axis=-1)
# Bars before a wall, in space: first, last x and how far away.
BARS = [(-0.9, -0.7, 1.2), (-0.2, 0.0, 1.4), (0.5, 0.75, 1.1)]


def seen(pose, bars=BARS):
    """Range and number of what is nearest: 0 the wall at 2 m, then the bars."""
    rays, at = RAYS @ pose[:3, :3].T, pose[:3, 3]
    along = [(2.0 - at[2]) / rays[..., 2]]
    for first, last, away in bars:
        far = (away - at[2]) / rays[..., 2]
        x = at[0] + far * rays[..., 0]
        along.append(np.where((x > first) & (x < last), far, np.inf))
    return np.min(along, axis=0) * np.linalg.norm(RAYS, axis=-1), np.argmin(along, axis=0)


def turned(angles, aside=0.0):
    """(F, 4, 4) of a camera that turns about the vertical, and is the farther aside the more it has."""
    poses = np.tile(np.eye(4), (len(angles), 1, 1))
    poses[:, :3, :3] = Rotation.from_rotvec(np.outer(angles, [0, 1, 0])).as_matrix()
    poses[:, 0, 3] = aside * np.asarray(angles)
    return poses


def numbers_of(found, truth):
    """Every number that the pixels of each true surface have, but for one in fifty of them."""
    out = []
    for which in np.unique(truth):
        number, many = np.unique(found[truth == which], return_counts=True)
        out.append(set(number[many > 0.02 * many.sum()].tolist()))
    return out


@pytest.mark.parametrize("aside", [0.0, 0.4])
def test_a_bar_that_leaves_the_view_has_its_number_when_it_returns(aside):
    poses = turned([0.0, 0.35, 0.7, 1.0, 0.7, 0.35, 0.0, -0.35, -0.7, -0.3, 0.0], aside)
    frames = [seen(pose) for pose in poses]
    ranges, truth = (np.stack([frame[i] for frame in frames]) for i in (0, 1))
    followed = numbers_of(segments(ranges.astype(np.float32), INTRINSICS, poses), truth)
    assert all(len(one) == 1 for one in followed)
    assert len(set.union(*followed)) == 4
    alone = numbers_of(segments(ranges.astype(np.float32), INTRINSICS), truth)
    assert any(len(one) > 1 for one in alone)


def test_what_goes_along_with_the_camera_is_followed_in_the_image():
    """A bar that the camera carries before it, in a room that it turns in."""
    carried = RAYS[..., 0] * 0.6
    bar = (carried > -0.15) & (carried < 0.1)
    frames = [seen(pose) for pose in turned(np.linspace(0, 0.6, 7))]
    ranges = np.stack([np.where(bar, 0.6 * np.linalg.norm(RAYS, axis=-1), frame[0]) for frame in frames])
    truth = np.stack([np.where(bar, 4, frame[1]) for frame in frames])
    followed = numbers_of(segments(ranges.astype(np.float32), INTRINSICS, turned(np.linspace(0, 0.6, 7))), truth)
    assert len(followed[-1]) == 1


def test_a_camera_that_stands_still_needs_no_places():
    frames = [seen(np.eye(4), [(x, x + 0.3, 1.0)]) for x in np.linspace(-0.6, 0.4, 9)]
    ranges = np.stack([frame[0] for frame in frames]).astype(np.float32)
    found = segments(ranges, INTRINSICS, np.tile(np.eye(4), (9, 1, 1)))
    np.testing.assert_array_equal(found, segments(ranges, INTRINSICS))


def test_other_places_of_the_same_frames_are_asked_anew():
    poses = turned([0.0, 0.5, 0.0, -0.5])
    ranges = np.stack([seen(pose)[0] for pose in poses]).astype(np.float32)
    there, nowhere = segments(ranges, INTRINSICS, poses), segments(ranges, INTRINSICS)
    assert (there != nowhere).any()
    np.testing.assert_array_equal(segments(ranges, INTRINSICS, poses), there)

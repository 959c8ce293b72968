"""Numbers at knots of a lattice in space: what of them each pixel gets."""

import numpy as np
import pytest

from physics.light import direct_light
from physics.motion import Motion
from physics.patchwork import PATCHES, SIDE, patchwork

INTRINSICS = np.array([[20.0, 0, 14.5], [0, 20.0, 9.5], [0, 0, 1]])
SHAPE = (2, 20, 30)


def seen(depth, motion=None):
    return direct_light(depth, INTRINSICS, None, time_s=[0.0, 0.1], motion=motion)


@pytest.fixture
def wall():
    """A facing wall a metre off, its corner unknown in one frame."""
    depth = np.ones(SHAPE)
    depth[1, :3, :3] = np.nan
    return seen(depth)


def columns(light):
    return np.stack([patchwork(one, light) for one in np.eye(PATCHES)], axis=-1)


def test_of_a_wall_it_is_bilinear_and_knots_are_counted_from_the_fullest(wall):
    found = columns(wall)
    there = wall.range_m > 0
    assert (found >= 0).all()
    np.testing.assert_allclose(found.sum(axis=-1)[there], 1, atol=1e-5)
    assert (found[~there] == 0).all()
    np.testing.assert_allclose(patchwork(0.7, wall)[there], 0.7, rtol=1e-5)
    full = found.sum(axis=(0, 1, 2))
    assert (np.diff(full) <= 1e-3).all()
    # A flat wall is seen by one layer of knots.
    assert np.count_nonzero(full > 1e-3) == SIDE**2
    v, u = np.indices(SHAPE[1:])
    for straight in (u - 14.5, v - 9.5, (u - 14.5) * (v - 9.5)):
        of_wall, known = found[0].reshape(-1, PATCHES), straight.ravel() / 20
        fitted = of_wall @ np.linalg.lstsq(of_wall, known, rcond=1e-6)[0]
        # Their product is straight along either axis between knots, and so is what is interpolated.
        np.testing.assert_allclose(fitted, known, atol=1e-4 * np.abs(known).max())


def test_it_stays_with_what_is_seen_while_the_camera_moves():
    """A wall seen from two places: what both see of it is the same."""
    poses = np.tile(np.eye(4), (2, 1, 1))
    poses[1, 0, 3] = 4 / 20  # By four pixels at a metre.
    light = seen(np.ones(SHAPE), Motion(np.array([0, 0.1]), poses))
    found = patchwork(np.sin(np.arange(PATCHES)), light)
    np.testing.assert_allclose(found[1, :, :-4], found[0, :, 4:], atol=1e-5)


def test_of_some_frames_it_is_what_the_session_says(wall):
    numbers = np.cos(np.arange(PATCHES))
    np.testing.assert_array_equal(patchwork(numbers, wall.of(np.array([1])))[0], patchwork(numbers, wall)[1])


def test_where_nothing_is_seen_there_is_nothing():
    assert (patchwork(1.0, seen(np.full(SHAPE, np.nan))) == 0).all()

"""Things that move before a wall, told from it and followed."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from physics.bodies import bodies
from physics.light import direct_light

SHAPE = (40, 60)
INTRINSICS = np.array([[50.0, 0, 29.5], [0, 50, 19.5], [0, 0, 1]])
RAYS = np.stack([*np.meshgrid((np.arange(60) - 29.5) / 50, (np.arange(40) - 19.5) / 50), np.ones(SHAPE)], axis=-1)
TIMES = np.linspace(0, 1, 9)
HALF = np.array([0.2, 0.15, 0.2])


def box(middle, turn):
    """(H, W) depth of a box (slabs: Kay and Kajiya 1986), infinite beside it."""
    rotation = Rotation.from_rotvec(turn).as_matrix()
    with np.errstate(divide="ignore"):
        ends = np.stack([(side * HALF + rotation.T @ middle) / (RAYS @ rotation) for side in (-1, 1)])
    enter, leave = ends.min(axis=0).max(axis=-1), ends.max(axis=0).min(axis=-1)
    return np.where(enter < leave, enter, np.inf)


def session(middles, turns, wall=2.0):
    depth = np.array([np.minimum(box(m, t), wall) for m, t in zip(middles, turns, strict=True)])
    return direct_light(depth, INTRINSICS, time_s=TIMES), depth < wall


EVEN = np.ones(9)
WAYS = {
    "carried aside": (
        np.c_[0.5 * np.sin(3 * TIMES), 0.1 * TIMES, 1 + 0.2 * TIMES],
        np.c_[0 * EVEN, 0.5 * EVEN, 0 * EVEN],
    ),
    "turning in its place": (np.tile([0.0, 0, 1.0], (9, 1)), np.c_[0 * EVEN, 0.4 + 0.4 * TIMES, 0 * EVEN]),
}


@pytest.mark.parametrize("way", WAYS)
def test_a_box_is_told_from_the_wall_and_followed(way):
    middles, turns = WAYS[way]
    light, box_there = session(middles, turns)
    rest, *found = bodies(light)
    (thing,) = found
    np.testing.assert_array_equal(rest.motion.start_from_camera, np.tile(np.eye(4), (9, 1, 1)))
    assert (thing.there != box_there).mean() < 0.01
    assert (rest.there == ~thing.there).all()
    # Its middle, seen from a camera that moves instead of it, stays where it was.
    still = np.einsum("fij,fj->fi", thing.motion.start_from_camera, np.c_[middles, np.ones(9)])[:, :3]
    np.testing.assert_allclose(still, np.tile(middles[0], (9, 1)), atol=0.05)
    turned = Rotation.from_matrix(thing.motion.start_from_camera[:, :3, :3]).as_rotvec()
    np.testing.assert_allclose(turned, turns[:1] - turns, atol=0.05)


def test_where_nothing_moves_there_is_the_rest_alone():
    light, _ = session(np.tile([0.0, 0, 1.0], (9, 1)), np.tile([0.0, 0.5, 0], (9, 1)))
    (rest,) = bodies(light)
    assert rest.there.all()


def test_nothing_known_is_no_thing():
    light = direct_light(np.full((9, *SHAPE), np.nan), INTRINSICS, time_s=TIMES)
    assert len(bodies(light)) == 1

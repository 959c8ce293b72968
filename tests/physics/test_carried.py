"""Light that is carried along, against scenes rendered anew from where the camera is by then."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from physics.bodies import Body
from physics.carried import carried, carriers
from physics.light import direct_light
from physics.motion import Motion

INTRINSICS = np.array([[40.0, 0, 19.5], [0, 40.0, 14.5], [0, 0, 1]])
TIMES = np.array([0.0, 0.1, 0.2])
RAYS = np.stack([*np.meshgrid((np.arange(40) - 19.5) / 40, (np.arange(30) - 14.5) / 40), np.ones((30, 40))], axis=-1)


def pose(time_s, moved=(0.3, -0.2, 0.5), turned=(0.1, 0.3, -0.2)):
    """World from a camera that moves and turns evenly."""
    out = np.eye(4)
    out[:3, :3] = Rotation.from_rotvec(np.array(turned) * time_s).as_matrix()
    out[:3, 3] = np.array(moved) * time_s
    return out


def wall(there, normal=(0.1, -0.05, -1.0), distance=1.5):
    """(H, W) depth along z, reflectance and cosine of a slanted wall of the world, brighter to the right."""
    n = np.array(normal) / np.linalg.norm(normal)
    rays = RAYS @ there[:3, :3].T
    depth = (-distance - n @ there[:3, 3]) / (rays @ n)
    points = there[:3, 3] + rays * depth[..., None]
    cosine = -(rays @ n) / np.linalg.norm(rays, axis=-1)
    return depth, 0.5 + 0.2 * points[..., 0], cosine


def seen(scene, times=TIMES, **moves):
    frames = [scene(pose(t, **moves)) for t in times]
    depth, albedo, cosine = (np.stack(part) for part in zip(*frames, strict=True))
    poses = np.stack([pose(t, **moves) for t in times])
    return direct_light(depth, INTRINSICS, albedo, cosine, time_s=times, motion=Motion.of(times, poses))


def moved(light, at):
    """All frames as they are seen from where the camera is at a time, from the two frames around it."""
    lower = np.full(3, 0 if at < 0.1 else 1)
    part = np.clip((at - TIMES[lower]) / 0.1, 0, 1)
    return carried(light, as_one(light), lower, lower + 1, part, np.full(3, at))


def as_one(light):
    """All that is seen, with the motion of the camera."""
    return (Body(light.motion, np.ones(light.range_m.shape, bool)),)


@pytest.mark.parametrize("at", [0.02, 0.05, 0.13, 0.25])
def test_a_wall_is_where_the_camera_sees_it_by_then(at):
    found, truth = moved(seen(wall), at), seen(wall, np.array([0.0, at]))
    inner = (1, slice(4, -4), slice(4, -4))
    np.testing.assert_allclose(found.range_m[inner], truth.range_m[inner], rtol=2e-3)
    strength = sum(way.strength for way in found.returns)
    np.testing.assert_allclose(strength[inner], truth.returns[0].strength[inner], rtol=0.03)


@pytest.mark.parametrize("at", [0.03, 0.06])
def test_an_edge_that_the_camera_passes_is_in_place(at):
    """A box before a wall, ten pixels wide and 1 m away, seen by a camera that moves aside: by the mean column."""

    def box(there):
        middle = 40 * (0.1 - there[0, 3]) + 19.5
        near = np.broadcast_to(np.abs(np.arange(40) - middle) < 5, (30, 40))
        return np.where(near, 1.0, 2.0), np.ones((30, 40)), np.ones((30, 40))

    found = moved(seen(box, moved=(0.5, 0, 0), turned=(0, 0, 0)), at)
    length = np.linalg.norm(RAYS, axis=-1)
    near = sum(way.strength * way.range_m**2 * (way.range_m < 1.4 * length) for way in found.returns)[0]
    assert (near.sum(axis=0) @ np.arange(40)) / near.sum() == pytest.approx(40 * (0.1 - 0.5 * at) + 19.5, abs=0.6)
    # All that is wider than a pixel is as wide as it was, but for the wall that the box hid, of which there is none.
    assert near[0].sum() == pytest.approx(10, abs=1)


@given(seed=st.integers(0, 100), at=st.floats(-0.05, 0.25))
@example(seed=1, at=1.8682658168780467e-44)
def test_what_is_not_known_is_not_made_up(seed, at):
    rng = np.random.default_rng(seed)
    depth = np.where(rng.random((3, 30, 40)) < 0.3, np.nan, rng.uniform(0.2, 3, (3, 30, 40)))
    poses = np.stack([pose(t) for t in TIMES])
    light = direct_light(depth, INTRINSICS, cosine=np.ones((3, 30, 40)), time_s=TIMES, motion=Motion.of(TIMES, poses))
    for way in moved(light, at).returns:
        assert (way.strength >= 0).all()
        assert (way.range_m > 0).all()
    blind = direct_light(depth * np.nan, INTRINSICS, cosine=np.ones((3, 30, 40)), time_s=TIMES, motion=light.motion)
    dark = moved(blind, at)
    assert not any(way.strength.any() for way in dark.returns)
    assert (dark.missing == 1200).all()


def sliding(times):
    """A plate 1 m away, ten pixels wide and as many high, that slides before a wall at 2 m; which pixels see it."""
    middle = 12 + 80 * np.asarray(times)[:, None, None]
    plate = (np.abs(np.arange(40) - middle) < 5) & (np.abs(np.arange(30)[:, None] - 15) < 5)
    depth = np.where(plate, 1.0, 2.0)
    return direct_light(depth, INTRINSICS, cosine=np.ones(depth.shape), time_s=np.asarray(times)), plate


@pytest.mark.parametrize("at", [0.025, 0.05, 0.075])
def test_a_thing_that_moves_hides_what_is_behind_it_and_gives_free_what_was(at):
    light, plate = sliding(TIMES)
    still, slides = np.tile(np.eye(4), (2, 3, 1, 1))
    slides[:, 0, 3] = -2 * TIMES  # 80 pixels a second at 1 m: a camera that goes the other way by 2 m/s.
    things = Body(Motion(TIMES, still), ~plate), Body(Motion(TIMES, slides), plate)
    lower = np.full(3, 0)
    found = carried(light, things, lower, lower + 1, np.full(3, at / 0.1), np.full(3, at))
    truth, _ = sliding(np.full(3, at))
    near = found.range_m < 1.6 * np.linalg.norm(RAYS, axis=-1)
    assert 81 <= near[0].sum() <= 100  # Nine or ten pixels either way.
    for limit in (1.6, 9.0):  # Light of the plate, and all of it.
        length = limit * np.linalg.norm(RAYS, axis=-1)
        mine, its = (sum((w.strength * (w.range_m < length))[0].sum() for w in of.returns) for of in (found, truth))
        assert mine == pytest.approx(its, rel=0.12)


def test_each_thing_is_carried_by_itself_where_that_tells_frames_better():
    """A plate that slides by two pixels a frame; and one that is too small to be followed, in a scene that nears."""
    light, plate = sliding(0.025 * np.arange(9))
    rest, thing = carriers(light)
    assert (thing.there == plate).mean() > 0.99
    assert (rest.there != thing.there).all()
    some = carriers(light.of(np.array([2, 4])))
    np.testing.assert_array_equal(some[1].there, thing.there[[2, 4]])
    assert len(carriers(seen(wall))) == 1

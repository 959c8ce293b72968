"""Light that is put in slots is neither lost nor made; points and pixels are those of homogeneous coordinates."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from physics.seen_from import filled, from_there, looking, put, sources

INTRINSICS = np.array([[30.0, 0.0, 11.5], [0.0, 30.0, 8.5], [0.0, 0.0, 1.0]])
V, U = np.mgrid[:18, :24].astype(float)
RAYS = np.stack([(U - 11.5) / 30, (V - 8.5) / 30, np.ones_like(U)], axis=-1)


def turned(seed):
    """A camera that has moved and turned a little, (4, 4) from before."""
    rng, there = np.random.default_rng(seed), np.eye(4)
    there[:3, :3] = Rotation.from_rotvec(rng.normal(0, 0.05, 3)).as_matrix()
    there[:3, 3] = rng.normal(0, 0.05, 3)
    return there


@given(st.integers(0, 1000))
def test_points_are_as_far_from_there_as_homogeneous_coordinates_say(seed):
    there = turned(seed)
    ranges = np.where(np.random.default_rng(seed).random(U.shape) < 0.2, 0, 1 + 0.05 * U)
    points = RAYS * (ranges / np.linalg.norm(RAYS, axis=-1))[..., None]
    moved = np.concatenate([points, np.ones_like(ranges)[..., None]], axis=-1) @ there.T
    then, ahead = from_there(ranges, RAYS, there)
    known = ranges > 0
    np.testing.assert_allclose(then[known], np.linalg.norm(moved[known][:, :3], axis=-1), rtol=1e-9)
    np.testing.assert_allclose(ahead[known], moved[known][:, 2], rtol=1e-9)
    assert not then[~known].any()


@given(st.floats(-0.1, 0.1), st.floats(0.8, 3.0))
def test_a_wall_ahead_is_seen_as_far_aside_as_the_camera_went(aside, away):
    """By f·t/z pixels, shared between the four pixels around, which fill all but what leaves the image."""
    there = np.eye(4)
    there[0, 3] = -aside
    then, ahead = from_there(away * np.linalg.norm(RAYS, axis=-1), RAYS, there)
    where, left = sources(ahead, RAYS, INTRINSICS, np.linalg.inv(there), 1.0, np.array((0, 18, 0, 24)))
    column = (left * (where % 24)).sum(axis=-1)
    np.testing.assert_allclose(column, np.clip(U + 30 * aside / away, 0, 23), atol=1e-4)
    np.testing.assert_allclose((left * (where // 24)).sum(axis=-1), V, atol=1e-4)
    assert (left[..., 0] == left.max(axis=-1)).all()
    np.testing.assert_allclose(filled(then, where, left)[0], 1.0, atol=1e-5)


@given(seed=st.integers(0, 10_000), many=st.integers(1, 6))
def test_what_is_put_in_slots_is_all_there(seed, many):
    rng = np.random.default_rng(seed)
    strength = np.where(rng.random((many, 3, 4)) < 0.4, rng.random((many, 3, 4)), 0)
    ranges = rng.uniform(0.2, 3, strength.shape)
    slot_ranges, slots = np.ones((3, 3, 4)), np.zeros((3, 3, 4))
    for r, s in zip(ranges, strength, strict=True):
        put(r, s, slot_ranges, slots)
    np.testing.assert_allclose(slots.sum(axis=0), strength.sum(axis=0), atol=1e-12)
    np.testing.assert_allclose((slots * slot_ranges).sum(axis=0), (strength * ranges).sum(axis=0), atol=1e-12)
    # Where there are no more than slots each is by itself.
    few = (strength > 0).sum(axis=0) <= 3
    every = np.concatenate([strength, np.zeros((3, 3, 4))])
    np.testing.assert_allclose(np.sort(slots, axis=0)[:, few], np.sort(every, axis=0)[-3:, few])


@given(st.integers(0, 1000), st.integers(2, 8), st.integers(4, 10), st.integers(0, 9))
def test_pixels_that_may_look_at_a_thing_are_all_that_do(seed, wide, high, aside):
    """Those of the box are among all the pixels' as they are without one, and no pixel beside them sees the thing."""
    there = turned(seed)
    inside = (abs(U - 5 - aside) < wide / 2) & (abs(V - 8) < high / 2)
    ranges = np.where(inside, np.linalg.norm(RAYS, axis=-1) * (1 + 0.01 * U), 0)
    then, ahead = from_there(ranges, RAYS, there)
    box = looking(ranges, then, RAYS, INTRINSICS, there)
    every, back = (0, 18, 0, 24), np.linalg.inv(there)
    where, left = sources(ahead, RAYS, INTRINSICS, back, 1.05, np.array(every))
    mine = sources(ahead, RAYS, INTRINSICS, back, 1.05, box)
    within = np.s_[box[0] : box[1], box[2] : box[3]]
    np.testing.assert_array_equal(where[within], mine[0])
    np.testing.assert_array_equal(left[within], mine[1])
    beside = filled(then, where, left)[0]
    beside[within] = 0
    assert not beside.any()

"""Points of a plane that stands still lie in it, wherever the camera is."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from physics.motion import Motion


@given(st.integers(0, 10_000))
def test_points_of_a_plane_stay_in_it(seed):
    rng = np.random.default_rng(seed)
    poses = np.tile(np.eye(4), (3, 1, 1))
    poses[:, :3, :3], poses[:, :3, 3] = Rotation.random(3, random_state=rng).as_matrix(), rng.normal(size=(3, 3))
    motion = Motion.of([0.0, 0.1, 0.2], poses)
    normal = np.array([0.6, 0.0, 0.8])
    across = np.array([[0, 1.0, 0], [0.8, 0, -0.6]])
    first = 0.7 * normal + rng.normal(size=(5, 2)) @ across
    world = first @ poses[0, :3, :3].T + poses[0, :3, 3]
    for i, time in enumerate((0.01, 0.09, 0.2)):
        now = (world - poses[i, :3, 3]) @ poses[i, :3, :3]
        axis, distance = motion.plane(normal, 0.7, time)
        np.testing.assert_allclose(now @ axis, distance, atol=1e-12)
        np.testing.assert_allclose(np.linalg.norm(axis), 1)


def test_the_beginning_may_lie_before_and_poses_may_be_unknown():
    poses = np.tile(np.eye(4), (2, 1, 1))
    poses[:, 2, 3] = 1.0, 1.5
    motion = Motion.of([4.0, 5.0], poses, start=np.eye(4))
    assert [motion.plane(np.array([0, 0, 1.0]), 3.0, time)[1] for time in (4.2, 7.0)] == [2.0, 1.5]
    assert Motion.of([0.0], None) is None


@given(st.integers(0, 10_000), st.floats(-0.5, 1.5))
def test_between_and_beyond_its_own_times_it_goes_on_evenly(seed, part):
    """On a straight line about one axis, whatever the two poses are it goes through."""
    rng = np.random.default_rng(seed)
    turn, velocity, start = rng.normal(size=3), rng.normal(size=3), Rotation.random(random_state=rng)
    turn *= rng.uniform(0, 1) / np.linalg.norm(turn)
    poses = np.tile(np.eye(4), (2, 1, 1))
    for i in range(2):
        poses[i, :3, :3] = (start * Rotation.from_rotvec(turn * i)).as_matrix()
        poses[i, :3, 3] = velocity * i
    motion = Motion.of([2.0, 4.0], poses, start=np.eye(4))
    (found,) = motion.at(np.array([2.0 + 2 * part]))
    np.testing.assert_allclose(found[:3, :3], (start * Rotation.from_rotvec(turn * part)).as_matrix(), atol=1e-9)
    np.testing.assert_allclose(found[:3, 3], velocity * part, atol=1e-12)
    alone = Motion.of([2.0], poses[:1], start=np.eye(4))
    np.testing.assert_allclose(alone.at(np.array([1.0, 2.0, 9.0])), np.tile(poses[0], (3, 1, 1)), atol=1e-12)


def test_between_its_own_times_it_goes_smoothly():
    """A way that swings, against itself between the times at which it is known."""

    def poses(times):
        out = np.tile(np.eye(4), (len(times), 1, 1))
        turns = np.c_[0.5 * np.sin(3 * times), 0.3 * np.cos(2 * times), 0.2 * times]
        out[:, :3, :3] = Rotation.from_euler("xyz", turns).as_matrix()
        out[:, :3, 3] = np.c_[np.sin(2 * times), times, np.cos(4 * times)]
        return out

    times, between = np.linspace(0, 3, 40), np.linspace(0, 3, 117)
    np.testing.assert_allclose(Motion(times, poses(times)).at(between), poses(between), atol=2e-3)
    after = np.array([3.002])
    np.testing.assert_allclose(Motion(times, poses(times)).at(after), poses(after), atol=5e-4)

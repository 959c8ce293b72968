import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from devices.arm.kinematics import forward, links, pose_of, transform
from devices.emulated.ur.arm import START_JOINTS
from devices.emulated.ur.motion import braking, by_joints, straight, trapezoid

ARM, START, TOOL = links("UR10"), np.array(START_JOINTS), np.array([0.0, 0.01, 0.05, 0, 0.1, 0])


def tool_at(joints):
    return pose_of(forward(ARM, joints) @ transform(TOOL))


@settings(max_examples=30)
@given(st.floats(1e-4, 2), st.floats(0.01, 1), st.floats(0.05, 3))
def test_a_trapezoid_covers_its_length_within_its_limits(length, speed, acceleration):
    profile = trapezoid(length, speed, acceleration)
    times = np.linspace(0, profile.lasts_s, 801)
    way, fast = np.array([profile.at(t) for t in times]).T
    # The way is the integral of the speed, the speed changes no faster than it may.
    step = times[1]
    assert way[-1] == pytest.approx(length, rel=1e-9)
    assert fast.max() <= speed * (1 + 1e-9)
    assert abs(np.diff(fast)).max() <= acceleration * step * (1 + 1e-6)
    np.testing.assert_allclose(np.cumsum((fast[1:] + fast[:-1]) / 2) * step, way[1:], atol=5e-3 * length)
    assert profile.at(profile.lasts_s + 1) == pytest.approx((length, 0.0))


def test_a_short_way_takes_as_long_as_physics_says():
    # Half the way speeding up, half slowing down: s/2 = a t^2 / 2.
    assert trapezoid(0.005, 0.25, 0.5).lasts_s == pytest.approx(2 * np.sqrt(0.005 / 0.5))
    assert trapezoid(0.5, 0.25, 0.5).lasts_s == pytest.approx(0.5 / 0.25 + 0.25 / 0.5)


def test_braking_takes_as_far_as_physics_says():
    profile = braking(0.1, 0.3, 2.0)
    assert profile.at(10)[0] == pytest.approx(0.1 + 0.3**2 / (2 * 2.0))
    assert profile.lasts_s == pytest.approx(0.15)


def test_a_straight_move_stays_on_its_line_and_turns_evenly():
    start, target = tool_at(START), tool_at(START)
    target[:3] += [0.05, -0.2, 0.1]
    target[3:] = (Rotation.from_rotvec(start[3:]) * Rotation.from_rotvec([0.1, 0.1, 0])).as_rotvec()
    motion = straight(ARM, TOOL, START, start, target, 0.25, 0.5, 7.0)
    along = target[:3] - start[:3]
    whole = (Rotation.from_rotvec(start[3:]).inv() * Rotation.from_rotvec(target[3:])).magnitude()
    for now in 7.0 + np.linspace(0, motion.profile.lasts_s, 23):
        pose = tool_at(motion.at(now)[0])
        share = (pose[:3] - start[:3]) @ along / (along @ along)
        np.testing.assert_allclose(pose[:3], start[:3] + share * along, atol=2e-6)
        turned = Rotation.from_rotvec(start[3:]).inv() * Rotation.from_rotvec(pose[3:])
        assert turned.magnitude() == pytest.approx(share * whole, abs=1e-4)
    np.testing.assert_allclose(tool_at(motion.at(99.0)[0]), target, atol=1e-9)
    assert motion.at(99.0)[2]


def test_speeds_of_joints_are_their_slopes():
    motion = by_joints(START, START + np.array([0.5, 0.1, 0, 0, -0.2, 0]), 1.0, 2.0, 0.0)
    before, after = (motion.at(t)[0] for t in (0.3999, 0.4001))
    np.testing.assert_allclose((after - before) / 2e-4, motion.at(0.4)[1], rtol=1e-3, atol=1e-9)
    np.testing.assert_allclose(motion.at(9)[1], 0)


def test_a_braked_move_rests_short_of_its_end_on_its_path():
    target = tool_at(START) + np.eye(6)[1] * 0.3
    motion = straight(ARM, TOOL, START, tool_at(START), target, 0.25, 0.5, 0.0)
    braked = motion.brake(0.7, 5.0)
    rest = tool_at(braked.at(50.0)[0])
    way = motion.profile.at(0.7)[0] + 0.25**2 / (2 * 5.0)
    np.testing.assert_allclose(rest[1] - tool_at(START)[1], way, atol=1e-6)
    # What ends anyway before it could brake is left alone.
    assert motion.brake(motion.profile.lasts_s - 1e-4, 0.1) is motion


@pytest.mark.parametrize("metres", [[-2.0, 0, 0], [0.8, 0.17, 0]])
def test_where_no_joints_lead_there_is_no_motion(metres):
    target = tool_at(START)
    target[:3] += metres
    assert straight(ARM, TOOL, START, tool_at(START), target, 0.25, 0.5, 0.0) is None


def test_no_way_is_over_at_once():
    motion = straight(ARM, TOOL, START, tool_at(START), tool_at(START), 0.25, 0.5, 3.0)
    joints, speeds, rests = motion.at(3.0)
    np.testing.assert_allclose(joints, START)
    np.testing.assert_allclose(speeds, 0)
    assert rests

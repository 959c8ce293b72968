from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from calibrate.rig import ArmSetup
from devices.arm.kinematics import forward, links, pose_of, transform
from devices.arm.reach import check_reach
from devices.emulated.ur.arm import START_JOINTS
from recordings.refusal import Refusal

SETUP = ArmSetup(model="UR10", tool=(0.01, -0.02, 0.05, 0.1, 0.0, 0.3))
START = np.array(START_JOINTS)


def tool_at(joints, setup=SETUP):
    return pose_of(forward(links(setup.model), np.asarray(joints)) @ transform(np.array(setup.tool)))


def grid(width_m, height_m, columns=9, rows=5):
    centre = tool_at(START)
    across, up = np.meshgrid(np.linspace(-0.5, 0.5, columns) * width_m, np.linspace(-0.5, 0.5, rows) * height_m)
    poses = np.tile(centre, (columns * rows, 1))
    poses[:, 1] += across.ravel()
    poses[:, 2] += up.ravel()
    return poses


def test_joints_on_the_way_bring_the_tool_to_every_pose():
    poses = grid(0.8, 0.45)
    path = check_reach(poses, SETUP, START)
    reached = np.array([tool_at(joints) for joints in path.joints])
    np.testing.assert_allclose(reached[:, :3], poses[:, :3], atol=1e-9)
    turned = Rotation.from_rotvec(reached[:, 3:]).inv() * Rotation.from_rotvec(poses[:, 3:])
    assert turned.magnitude().max() < 1e-8
    ways = np.diff(np.concatenate([tool_at(START)[None], poses])[:, :3], axis=0)
    assert path.metres == pytest.approx(sum(np.sqrt((way**2).sum()) for way in ways))


def test_joints_turn_on_past_half_a_turn():
    start = START.copy()
    start[5] -= 2 * np.pi
    path = check_reach(grid(0.3, 0.2), SETUP, start)
    assert path.joints[:, 5].max() < np.radians(-200)


def test_the_first_pose_too_far_is_named():
    poses = grid(0.4, 0.2)
    poses[7, 1] -= 2.0
    with pytest.raises(
        Refusal, match=r"UR10 does not get to position 8 of 45 \(on the way at .*\): it is \d+ mm too far"
    ):
        check_reach(poses, SETUP, START)


def test_by_how_much_it_is_too_far():
    # Where a straight arm gets whose forearm is 70 mm longer.
    joints = np.array([0.0, -0.9, 0.0, -0.3, 1.2, 0.4])
    longer = replace(links("UR10"), a3=links("UR10").a3 - 0.07)
    pose = pose_of(forward(longer, joints) @ transform(np.array(SETUP.tool)))
    bent = joints + np.array([0, 0, 0.2, 0, 0, 0])
    with pytest.raises(Refusal, match=r"position 1 of 1 .*it is 70 mm too far"):
        check_reach(pose[None], SETUP, bent)


def test_a_joint_at_its_limit_is_named():
    limited = replace(SETUP, joint_low_deg=(-360, -360, -360, -20, -360, -360))
    with pytest.raises(Refusal, match=r"joint 4 \(wrist 1\) would be at -2\d degrees, expected -20 to 360"):
        check_reach(grid(0.8, 0.45), limited, START)


def test_another_posture_that_would_do_is_pointed_out():
    limited = replace(SETUP, joint_high_deg=(360, 360, 0, 360, 360, 360))
    with pytest.raises(Refusal, match=r"joint 3 \(elbow\) would be at 9\d degrees.*in another posture it does"):
        check_reach(grid(0.2, 0.1), limited, START)


def test_a_wrist_that_would_race_is_named():
    taught = np.radians([90, -110.82, 151.63, -82.93, -180, 225.22])
    with pytest.raises(Refusal, match=r"position 1 of 1 .*joint 5 is at -?180.0 degrees, a singularity"):
        check_reach(tool_at(taught)[None], SETUP, taught)


def test_over_the_base_no_wrist_gets():
    pose = tool_at(START)
    pose[:2] = 0.0
    with pytest.raises(Refusal, match="position 1 of 1"):
        check_reach(pose[None], SETUP, START)


def test_a_single_pose_where_it_stands_needs_no_way():
    path = check_reach(tool_at(START)[None], SETUP, START)
    assert path.metres == pytest.approx(0, abs=1e-12)
    np.testing.assert_allclose(path.joints, START[None], atol=1e-9)

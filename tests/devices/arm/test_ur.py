import os
import signal
import subprocess
import sys
import threading

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from calibrate.rig import ArmSetup
from devices.arm.kinematics import forward, links, transform
from devices.arm.ur import open_arm
from devices.captures import ArmStopped, DeviceLost
from recordings.refusal import Refusal

TOOL = (0.0, 0.01, 0.05, 0.0, 0.0, 0.3)


def setup(controller, **other):
    return ArmSetup(**{"address": controller.host, "model": controller.model, "tool": TOOL, **other})


@pytest.fixture
def arm(controller):
    with open_arm(setup(controller), watchdog_s=30.0) as arm:
        yield arm


def beside(arm, *metres):
    pose = arm.pose
    pose[:3] += metres
    return pose


def test_it_says_what_it_is(arm):
    assert arm.said["model"] == "UR10"
    assert arm.said["controller"].startswith("URSoftware 3.15")
    assert arm.said["serial"] == "2014300001"
    assert arm.said["tool"] == list(TOOL)


def test_a_move_ends_where_it_was_sent_as_the_arm_itself_says(controller, arm):
    target = beside(arm, 0.02, -0.03, 0.01)
    target[3:] = (Rotation.from_rotvec(target[3:]) * Rotation.from_rotvec([0.05, 0, 0.02])).as_rotvec()
    settled = arm.move(target)
    np.testing.assert_allclose(settled.pose, target, atol=1e-9)
    np.testing.assert_allclose(controller.tool_pose, target, atol=1e-9)
    np.testing.assert_allclose(settled.joints, controller.joints, atol=1e-9)
    flange = forward(links("UR10"), settled.joints) @ transform(np.array(TOOL))
    np.testing.assert_allclose(flange[:3, 3], target[:3], atol=1e-9)
    assert settled.moving_s > 0
    assert not controller.state()["moving"]


def test_moves_add_up(controller, arm):
    first = arm.pose
    for i in range(5):
        arm.move(first + np.eye(6)[1] * 0.004 * (i % 2))
    assert controller.state()["moves"] == 5
    np.testing.assert_allclose(arm.move(first).pose, first, atol=1e-9)


def test_a_protective_stop_on_the_way_is_seen_released_and_survived(controller, arm):
    start, target = arm.pose, beside(arm, 0, 0.1, 0)
    controller.interrupt_move(2, "protective")
    arm.move(beside(arm, 0, 0.01, 0))
    with pytest.raises(ArmStopped, match="protective stop") as stopped:
        arm.move(target)
    assert stopped.value.kind == "protective"
    assert np.linalg.norm(arm.pose[:3] - target[:3]) > 1e-3
    with pytest.raises(ArmStopped, match="protective stop"):
        arm.move(target)
    arm.resume(unlock=True, wait_s=60)
    np.testing.assert_allclose(arm.move(target).pose, target, atol=1e-9)
    np.testing.assert_allclose(arm.move(start).pose, start, atol=1e-9)


def test_without_leave_nothing_is_unlocked(controller, arm):
    controller.protective_stop()
    with pytest.raises(ArmStopped, match="protective stop"):
        arm.resume(wait_s=0)
    assert controller.state()["safety_mode"] == 3


def test_an_emergency_stop_waits_for_people(controller, arm):
    controller.emergency_stop()
    with pytest.raises(ArmStopped, match="release the button") as stopped:
        arm.move(beside(arm, 0, 0.01, 0))
    assert stopped.value.kind == "emergency"
    with pytest.raises(ArmStopped, match="release the button"):
        arm.resume(unlock=True, wait_s=0)
    threading.Timer(0.05, lambda: [controller.interrupt(what) for what in ("released", "on")]).start()
    arm.resume(wait_s=60)
    arm.move(beside(arm, 0, 0.01, 0))


@pytest.mark.parametrize("what", ["program", "pause"])
def test_a_program_that_a_person_stops_is_started_again(controller, arm, what):
    controller.interrupt_move(1, what)
    target = beside(arm, 0, 0.1, 0)
    with pytest.raises(ArmStopped, match="program on the arm's controller is") as stopped:
        arm.move(target)
    assert stopped.value.kind == "program"
    arm.resume(wait_s=0)
    np.testing.assert_allclose(arm.move(target).pose, target, atol=1e-9)


def test_an_arm_that_did_not_move_is_no_measurement(controller, arm):
    controller.interrupt("stuck")
    with pytest.raises(ArmStopped, match=r"rests 30\.0 mm and 0\.00 degrees from where it was sent") as stopped:
        arm.move(beside(arm, 0.03, 0, 0))
    assert stopped.value.kind == "not moved"


def test_out_of_reach_is_a_stop(controller, arm):
    with pytest.raises(ArmStopped, match="could not reach"):
        arm.move(beside(arm, -2.0, 0, 0))


@pytest.mark.parametrize("how", ["hung up", "silent"])
def test_a_lost_line_is_opened_anew(controller, arm, how, impatient):
    target = beside(arm, 0, 0.02, 0)
    controller.interrupt(how)
    with impatient(), pytest.raises(DeviceLost, match="check its cable"):
        arm.move(target)
    with pytest.raises(DeviceLost):
        arm.pose  # noqa: B018
    controller.interrupt("plugged")
    arm.reopen(wait_s=60)
    np.testing.assert_allclose(arm.move(target).pose, target, atol=1e-9)


def test_who_comes_back_to_a_stopped_arm_resumes(controller, arm, impatient):
    controller.interrupt("hung up")
    with impatient(), pytest.raises(DeviceLost):
        arm.move(beside(arm, 0, 0.01, 0))
    controller.protective_stop()
    controller.interrupt("plugged")
    with pytest.raises(ArmStopped, match="protective stop"):
        arm.reopen(wait_s=60)
    arm.resume(unlock=True, wait_s=60)
    arm.move(beside(arm, 0, 0.01, 0))


def test_a_line_that_stays_away_is_lost(controller, arm):
    controller.interrupt("hung up")
    with pytest.raises(DeviceLost):
        arm.reopen(wait_s=0)


def test_leaving_stops_the_arm_and_its_program(controller):
    with open_arm(setup(controller)):
        assert controller.state()["playing"]
    state = controller.state()
    assert not state["playing"]
    assert not state["moving"]


def test_an_interrupt_from_the_keyboard_stops_the_arm(controller, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("devices.arm.ur.watched", interrupted)
    # So slow that the way takes minutes of the controller's.
    with open_arm(setup(controller), speed_m_s=0.001, watchdog_s=30.0) as arm:
        target = beside(arm, 0, 0.4, 0)
        with pytest.raises(KeyboardInterrupt):
            arm.move(target)
    rested = controller.state()
    assert not rested["moving"]
    assert np.linalg.norm(np.array(rested["pose"])[:3] - target[:3]) > 1e-3


def test_an_answer_that_nobody_waited_for_is_not_taken_for_another(arm, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    pose = arm.pose
    with monkeypatch.context() as patched:
        patched.setattr("devices.arm.link.select.select", interrupted)
        with pytest.raises(KeyboardInterrupt):
            arm._link.ask("running")
    np.testing.assert_allclose(arm.pose, pose)


@pytest.mark.parametrize("pose", [[0.1, 0.2, 0.3], [np.nan] * 6])
def test_what_is_no_pose_is_refused(controller, arm, pose):
    with pytest.raises(Refusal, match="expected metres and rotation vector, six numbers"):
        arm.move(pose)
    assert controller.state()["moves"] == 0


def test_when_the_scan_is_killed_the_arm_stops(controller):
    scan = f"""
from calibrate.rig import ArmSetup
from devices.arm.ur import open_arm
arm = open_arm(ArmSetup(address={controller.host!r}, tool={TOOL!r}), speed_m_s=0.001, watchdog_s=30.0)
pose = arm.pose
pose[1] += 0.4
print("moving", flush=True)
arm.move(pose)
"""
    with subprocess.Popen([sys.executable, "-c", scan], stdout=subprocess.PIPE) as process:
        assert process.stdout.readline() == b"moving\n"
        process.kill()
    while controller.state()["playing"] or controller.state()["moving"]:
        threading.Event().wait(0.01)
    assert controller.tool_pose[1] < 0.2


def test_when_the_process_that_commands_dies_the_watchdog_stops_the_program(controller):
    arm = open_arm(setup(controller), watchdog_s=0.5)
    os.kill(arm._link._process.pid, signal.SIGKILL)
    # Whether it stopped in time is not for a test; that it stops at all is.
    while controller.state()["playing"]:
        threading.Event().wait(0.01)
    with pytest.raises(DeviceLost):
        arm.move(np.zeros(6))
    arm.close()


@pytest.mark.parametrize(
    ("before", "sentence"),
    [
        ("protective", "stopped for safety \\(protective stop\\): find out why"),
        ("emergency", "emergency stop: release the button"),
        ("off", "not ready to move \\(power off\\): switch it on"),
        ("foreign", "a program is running on its controller"),
    ],
)
def test_what_is_wrong_before_anything_moves_is_one_sentence(controller, before, sentence):
    controller.interrupt(before)
    with pytest.raises(Refusal, match=sentence):
        open_arm(setup(controller))


def test_another_model_than_the_rig_says_is_refused(controller):
    with pytest.raises(Refusal, match=r"arm\.model UR5 has the tool \d+ mm from where the arm says"):
        open_arm(setup(controller, model="UR5"))


@pytest.mark.parametrize(
    ("address", "sentence"),
    [
        ("", r"arm\.address is empty"),
        ("127.0.0.250", "is there but does not answer on port 29999"),
        ("no such machine", "no machine is called"),
    ],
)
def test_nobody_at_the_address(address, sentence):
    with pytest.raises(Refusal, match=sentence):
        open_arm(ArmSetup(address=address))


def test_no_speed_is_no_move(controller):
    with pytest.raises(Refusal, match="speed 0"):
        open_arm(setup(controller), speed_m_s=0)


def test_an_e_series_arm_in_local_mode_is_refused(e_series):
    e_series.interrupt("local")
    with pytest.raises(Refusal, match="local mode: choose Remote Control"):
        open_arm(setup(e_series))
    e_series.interrupt("remote")
    with open_arm(setup(e_series)) as arm:
        assert arm.said["controller"].startswith("URSoftware 5.11")
        target = beside(arm, 0, 0.01, 0)
        np.testing.assert_allclose(arm.move(target).pose, target, atol=1e-9)

import numpy as np
import pytest

from devices.arm.kinematics import forward, links, pose_of
from devices.emulated.ur.arm import START_JOINTS
from devices.emulated.ur.controller import Controller
from devices.emulated.ur.dashboard import answer

READY, DONE = 1, 2
MOVE_L, MOVE_J, SET_TCP, STOP_L, WATCHDOG, TCP_OFFSET, STEADY, PROTECT, STOP_SCRIPT = 3, 1, 29, 33, 35, 40, 47, 31, 255


class Rig:
    """A controller whose clocks are turned by hand."""

    def __init__(self, model="UR10e"):
        self.now = self.host = 100.0
        self.controller = Controller(model, START_JOINTS, lambda: self.now, lambda: self.host)

    def wait(self, seconds):
        self.now += seconds
        return self.said()

    def said(self):
        return {
            name: value[0] if len(value) == 1 else np.array(value) for name, value in self.controller.values().items()
        }

    @property
    def state(self):
        return self.said()["output_int_register_0"]

    def start(self):
        self.controller.run_script(b"def x():\nend\n")
        return self

    def order(self, command, *numbers, asynchronous=0):
        registers = {f"input_double_register_{i}": float(number) for i, number in enumerate(numbers)}
        self.controller.write_registers(
            {"input_int_register_0": command, **registers, "input_int_register_1": asynchronous}
        )

    def clear(self):
        self.controller.write_registers({"input_int_register_0": 0})

    def target(self, *metres):
        pose = pose_of(forward(links(self.controller.model), np.array(START_JOINTS)))
        pose[:3] += metres or (0, 0, 0)
        return pose


@pytest.fixture
def rig():
    return Rig().start()


def test_a_program_makes_it_ready():
    rig = Rig()
    assert (rig.said()["runtime_state"], rig.state, rig.said()["robot_status_bits"]) == (1, 0, 1)
    rig.start()
    assert (rig.said()["runtime_state"], rig.state, rig.said()["robot_status_bits"]) == (2, READY, 3)


def test_a_move_is_done_when_it_rests(rig):
    target = rig.target(0, 0.1, 0)
    rig.order(MOVE_L, *target, 0.25, 0.5)
    assert rig.state == READY
    halfway = rig.wait(0.45)
    assert halfway["actual_TCP_speed"][1] == pytest.approx(0.5 * np.sqrt(0.1 / 0.5), rel=0.05)
    assert rig.wait(0.46)["output_int_register_0"] == DONE
    np.testing.assert_allclose(rig.said()["actual_TCP_pose"], target, atol=1e-9)
    rig.clear()
    assert rig.state == READY


def test_an_asynchronous_move_is_done_at_once_and_counts_its_progress(rig):
    before = rig.said()["output_int_register_2"]
    rig.order(MOVE_L, *rig.target(0, 0.1, 0), 0.25, 0.5, asynchronous=1)
    runs = rig.said()
    assert runs["output_int_register_0"] == DONE
    assert runs["output_int_register_2"] >> 15 & 1
    assert (runs["output_int_register_2"] >> 24) - (before >> 24) == 1
    over = rig.wait(5)["output_int_register_2"]
    assert not over >> 15 & 1
    assert (over >> 16 & 127) - (runs["output_int_register_2"] >> 16 & 127) == 1


def test_a_command_is_done_once_however_often_it_is_written(rig):
    target = rig.target(0, 0.1, 0)
    for _ in range(3):
        rig.order(MOVE_L, *target, 0.25, 0.5, asynchronous=1)
    assert rig.controller.moves == 1


def test_a_protective_stop_is_never_called_done(rig):
    rig.order(MOVE_L, *rig.target(0, 0.2, 0), 0.25, 0.5)
    rig.wait(0.5)
    rig.controller.interrupt("protective")
    stopped = rig.wait(60)
    assert stopped["safety_status_bits"] >> 2 & 1
    assert (stopped["safety_mode"], stopped["runtime_state"], stopped["output_int_register_0"]) == (3, 4, READY)
    np.testing.assert_allclose(stopped["actual_qd"], 0)


def test_protective_stops_are_unlocked_after_five_seconds(rig):
    rig.controller.interrupt("protective")
    rig.wait(4.9)
    assert answer(rig.controller, "unlock protective stop").startswith("Cannot unlock protective stop until 5s")
    rig.wait(0.2)
    assert answer(rig.controller, "unlock protective stop") == "Protective stop releasing"
    assert answer(rig.controller, "safetystatus") == "Safetystatus: NORMAL"
    assert rig.start().state == READY


def test_after_an_emergency_power_and_brakes_come_back_one_by_one(rig):
    rig.controller.interrupt("emergency")
    said = rig.said()
    assert said["safety_status_bits"] >> 7 & 1
    assert (said["robot_mode"], said["runtime_state"]) == (3, 1)
    answer(rig.controller, "power on")
    assert answer(rig.controller, "robotmode") == "Robotmode: POWER_OFF"
    rig.controller.interrupt("released")
    assert answer(rig.controller, "power on") == "Powering on"
    assert answer(rig.controller, "robotmode") == "Robotmode: IDLE"
    assert rig.start().said()["runtime_state"] == 1
    assert answer(rig.controller, "brake release") == "Brake releasing"
    assert rig.start().said()["runtime_state"] == 2


def test_out_of_reach_is_a_protective_stop_before_anything_moves(rig):
    rig.order(MOVE_L, *rig.target(-3, 0, 0), 0.25, 0.5)
    said = rig.said()
    assert said["safety_mode"] == 3
    assert said["output_int_register_0"] == READY
    np.testing.assert_allclose(said["actual_q"], START_JOINTS)


def test_the_watchdog_counts_silence_only(rig):
    rig.order(WATCHDOG, 2.0)
    rig.clear()
    for _ in range(10):
        rig.host += 0.4
        rig.clear()
        assert rig.said()["runtime_state"] == 2
    rig.order(MOVE_L, *rig.target(0, 0.2, 0), 0.25, 0.5, asynchronous=1)
    rig.wait(0.3)
    rig.host += 0.6
    assert rig.said()["runtime_state"] == 1
    rested = rig.wait(9)["actual_TCP_pose"]
    assert 0.01 < rested[1] - rig.target()[1] < 0.15


def test_a_stop_breaks_off_a_move(rig):
    rig.order(MOVE_L, *rig.target(0, 0.2, 0), 0.25, 0.5, asynchronous=1)
    rig.clear()
    rig.wait(0.6)
    rig.order(STOP_L, 10.0)
    assert rig.state == READY
    said = rig.wait(0.1)
    assert said["output_int_register_0"] == DONE
    assert not said["output_int_register_2"] >> 15 & 1
    assert said["actual_TCP_pose"][1] - rig.target()[1] < 0.1


def test_the_tool_moves_the_pose_but_not_the_arm(rig):
    rig.order(SET_TCP, 0, 0, 0.1, 0, 0, 0)
    rig.clear()
    rig.order(TCP_OFFSET)
    said = rig.said()
    assert [said[f"output_double_register_{i}"] for i in range(3)] == [0, 0, 0.1]
    flange = forward(links("UR10e"), np.array(START_JOINTS))
    np.testing.assert_allclose(said["actual_TCP_pose"][:3], flange[:3, 3] + 0.1 * flange[:3, 2])
    rig.clear()
    rig.order(STEADY)
    assert rig.said()["output_int_register_1"] == 1


def test_a_move_of_joints_ends_at_them(rig):
    target = np.array(START_JOINTS) + 0.1
    rig.order(MOVE_J, *target, 1.0, 1.0)
    np.testing.assert_allclose(rig.wait(9)["actual_q"], target, atol=1e-12)


def test_a_stop_that_was_ordered_comes_half_way(rig):
    rig.controller.stops[1] = "program"
    rig.order(MOVE_L, *rig.target(0, 0.2, 0), 0.25, 0.5)
    for _ in range(200):
        said = rig.wait(0.01)
    assert said["runtime_state"] == 1
    assert 0.09 < said["actual_TCP_pose"][1] - rig.target()[1] < 0.15


def test_the_program_can_stop_the_arm_for_safety(rig):
    rig.order(PROTECT)
    assert rig.said()["safety_mode"] == 3


def test_a_client_that_was_heard_late_was_heard(rig):
    rig.order(WATCHDOG, 2.0)
    rig.host += 60.0
    rig.clear()
    assert rig.said()["runtime_state"] == 2


def test_the_script_ends_when_told(rig):
    rig.order(STOP_SCRIPT)
    assert rig.said()["runtime_state"] == 1


def test_local_mode_takes_no_programs_and_no_orders():
    rig = Rig()
    rig.controller.interrupt("local")
    assert rig.start().said()["runtime_state"] == 1
    assert answer(rig.controller, "is in remote control") == "false"
    assert "not allowed" in answer(rig.controller, "power off")
    assert answer(rig.controller, "robotmode") == "Robotmode: RUNNING"


def test_older_controllers_know_no_remote_mode():
    controller = Rig("UR5").controller
    assert answer(controller, "is in remote control") == "could not understand: 'is in remote control'"
    assert answer(controller, "PolyscopeVersion").startswith("URSoftware 3.15")
    assert controller.hertz == 125


def test_a_program_is_seen_on_the_dashboard(rig):
    assert answer(rig.controller, "running") == "Program running: true"
    assert answer(rig.controller, "programState") == "PLAYING <unnamed>"
    assert answer(rig.controller, "stop") == "Stopped"
    assert answer(rig.controller, "programState") == "STOPPED <unnamed>"


def test_nothing_unheard_of_happens(rig):
    with pytest.raises(ValueError, match="'earthquake', expected one of protective, "):
        rig.controller.interrupt("earthquake")

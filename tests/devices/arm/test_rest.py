import numpy as np
import pytest

from devices.arm.link import State
from devices.arm.rest import Goal, watched
from devices.captures import ArmStopped

TARGET, GOAL = np.array([0.5, 0.1, 0.2, 0.0, 1.0, 0.0]), Goal(2e-4, 2e-3)


class Told:
    """A line on which the given states arrive, 125 a second, and the last of them for ever."""

    def __init__(self, *states):
        self.states, self.asked = states, 0

    def state(self, following=True):
        state = self.states[min(self.asked, len(self.states) - 1)]
        self.asked += 1
        return State(time_s=self.asked / 125, **state)


def seen(offset_m=0.0, speed_m_s=0.0, operating=False, turned=0.0, **other):
    return {
        "pose": TARGET + np.array([0, offset_m, 0, 0, turned, 0]),
        "speed": np.array([0, speed_m_s, 0, 0, 0, 0]),
        "joints": np.full(6, offset_m),
        "safety_bits": 1,
        "robot_mode": 7,
        "runtime_state": 2,
        "operating": operating,
    } | other


def test_what_passes_through_the_target_does_not_rest_there():
    line = Told(*[seen(speed_m_s=0.2, operating=True)] * 40, seen(offset_m=1e-5))
    pose, joints = watched(line, TARGET, GOAL)
    np.testing.assert_allclose(pose, TARGET + np.eye(6)[1] * 1e-5)
    np.testing.assert_allclose(joints, 1e-5)
    assert line.asked == 40 + 3


def test_a_move_that_begins_late_is_waited_for():
    line = Told(*[seen(offset_m=0.1)] * 20, *[seen(offset_m=0.05, speed_m_s=0.1, operating=True)] * 500, seen())
    assert watched(line, TARGET, GOAL)[0] == pytest.approx(TARGET)


@pytest.mark.parametrize(("operating", "lasts_s"), [(False, 0.5), (True, 5.0)])
def test_what_rests_elsewhere_is_no_measurement(operating, lasts_s):
    line = Told(seen(offset_m=0.1, operating=operating))
    with pytest.raises(ArmStopped, match=r"rests 100\.0 mm and 0\.00 degrees") as stopped:
        watched(line, TARGET, GOAL)
    assert stopped.value.kind == "not moved"
    assert line.asked / 125 == pytest.approx(lasts_s, abs=0.05)


def test_the_right_place_turned_the_wrong_way_is_elsewhere():
    with pytest.raises(ArmStopped, match=r"rests 0\.0 mm and 0\.57 degrees"):
        watched(Told(seen(turned=0.01)), TARGET, GOAL)


@pytest.mark.parametrize(
    ("state", "kind", "sentence"),
    [
        ({"safety_bits": 1 << 2}, "protective", "protective stop: see what it ran into"),
        ({"safety_bits": 1 << 4}, "protective", "a safeguard holds the arm"),
        ({"safety_bits": 1 << 6 | 1 << 7}, "emergency", "release the button"),
        ({"safety_bits": 1 << 9}, "protective", "a safety fault"),
        ({"safety_bits": 1 << 10}, "protective", "stopped for safety"),
        ({"robot_mode": 5}, "emergency", "its brakes are on"),
        ({"runtime_state": 4}, "program", "controller is paused"),
        ({"runtime_state": 1}, "program", "controller is stopped"),
    ],
)
def test_every_stop_has_its_sentence(state, kind, sentence):
    with pytest.raises(ArmStopped, match=sentence) as stopped:
        watched(Told(seen(offset_m=0.1, operating=True), seen(**state)), TARGET, GOAL)
    assert stopped.value.kind == kind


def test_the_reason_may_come_after_the_end():
    line = Told(seen(runtime_state=1), seen(runtime_state=1), seen(runtime_state=1, safety_bits=1 << 7))
    with pytest.raises(ArmStopped, match="emergency stop"):
        watched(line, TARGET, GOAL)

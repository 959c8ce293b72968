"""The program that ur_rtde runs on a controller, as its registers show it.

Commands come in the client's input_int_register_0 with their arguments in the other registers; output_int_register_0
says 1 for ready and 2 for done, and returns to 1 when the command is cleared. output_int_register_2 counts asynchronous
operations: bit 15 while one runs, bits 16 to 22 count changes, bits 24 to 30 operations.
"""

from collections.abc import Mapping

import numpy as np

from devices.arm.kinematics import forward, inverse, inverted, pose_of, transform
from devices.emulated.ur.motion import by_joints, straight
from devices.emulated.ur.safety import PLAYING

MOVE_J, MOVE_J_IK, MOVE_L, MOVE_L_FK, SET_TCP, STOP_L, STOP_J, SET_WATCHDOG = 1, 2, 3, 4, 29, 33, 34, 35
GET_TCP_OFFSET, IS_STEADY, PROTECT, STOP_SCRIPT = 40, 47, 31, 255
READY, DONE = 1, 2
OUTPUTS = 24


class Script:
    """The registers of a controller; part of `Controller`, which has the clock and the arm."""

    def clear_script(self) -> None:
        """No program has begun."""
        self.inputs: dict[str, float] = {}
        self.output_ints, self.output_doubles = [0] * OUTPUTS, [0.0] * OUTPUTS
        self._executing = False
        self._waits, self._works = False, False
        self._changes, self._operations = 0, 0
        self._silence_s = 0.0
        self._heard_s = self.host_clock()

    def run_script(self, text: bytes) -> None:
        """A program came; it runs if the arm may move, and takes the place of another."""
        del text  # Taken for ur_rtde's: nothing else is sent by the driver.
        if self.scripted:
            self.end_program()
            self.runtime_state = PLAYING
            self.output_ints[0] = READY
            self.stirred = True

    def write_registers(self, values: Mapping[str, float]) -> None:
        """A client wrote; a command is looked at after its arguments."""
        self._heard_s = self.host_clock()
        self.advance()
        self.inputs.update(values)
        if not self.playing or "input_int_register_0" not in values:
            return
        command = int(values["input_int_register_0"])
        if command == 0:
            self._executing = False
            if not self._waits:
                self._say(READY)
        elif not self._executing:
            self._executing = True
            self._do(command)

    def watch(self) -> None:
        """The program ends, and the arm halts, when its client has been silent for longer than the watchdog allows."""
        if self.playing and self._silence_s and self.host_clock() - self._heard_s > self._silence_s:
            self.stop_program()

    def finish(self) -> None:
        """Say that a motion has ended, unless it was stopped from outside."""
        if self.motion is None and self.playing:
            if self._waits:
                self._waits = False
                self._say(DONE)
            if self._works:
                self._progress(False)

    def _say(self, state: int) -> None:
        if self.output_ints[0] != state:
            self.output_ints[0] = state
            self.stirred = True

    def _progress(self, runs: bool) -> None:
        self._works = runs
        self._changes = (self._changes + 1) % 128
        self._operations = (self._operations + runs) % 128
        self.output_ints[2] = self._operations << 24 | self._changes << 16 | runs << 15
        self.stirred = True

    def _numbers(self, count: int, first: int = 0) -> np.ndarray:
        return np.array([self.inputs.get(f"input_double_register_{first + i}", 0.0) for i in range(count)])

    def _do(self, command: int) -> None:
        if command == STOP_SCRIPT:
            self.stop_program()
        elif command == PROTECT:
            self.protective_stop()
        elif command in (MOVE_J, MOVE_J_IK, MOVE_L, MOVE_L_FK):
            self._move(command)
        elif command in (STOP_L, STOP_J):
            self.brake(max(self._numbers(1)[0], 1e-3))
            self._follow(self.motion is not None)
        else:
            self._set_or_tell(command)
            self._say(DONE)

    def _set_or_tell(self, command: int) -> None:
        if command == SET_TCP:
            self.tool = self._numbers(6)
        elif command == GET_TCP_OFFSET:
            self.output_doubles[:6] = self.tool.tolist()
        elif command == IS_STEADY:
            self.output_ints[1] = int(self.motion is None)
        elif command == SET_WATCHDOG:
            hertz = self._numbers(1)[0]
            self._silence_s = 1 / hertz if hertz > 0 else 0.0

    def _move(self, command: int) -> None:
        """Set off; what cannot be reached is a protective stop before anything moves."""
        target, (speed, acceleration) = self._numbers(6), self._numbers(2, 6)
        joints, now, tool = self.joints_now()[0], self.clock(), transform(self.tool)
        if command == MOVE_L_FK:
            target = pose_of(forward(self.arm, target) @ tool)
        if command in (MOVE_L, MOVE_L_FK):
            start = pose_of(forward(self.arm, joints) @ tool)
            motion = straight(self.arm, self.tool, joints, start, target, speed, acceleration, now)
        else:
            if command == MOVE_J_IK:
                target = self._nearest(transform(target) @ inverted(tool), joints)
            motion = by_joints(joints, target, speed, acceleration, now)
        if motion is None or not np.isfinite(motion.joints).all():
            self.protective_stop()
            return
        self.at_rest = joints
        self.begin(motion)
        self._follow(True)

    def _follow(self, moving: bool) -> None:
        """Say that it is done when the arm rests or, asked to be asynchronous, at once."""
        if self._works:
            self._progress(False)
        asynchronous = self.inputs.get("input_int_register_1", 0) == 1
        self._waits = moving and not asynchronous
        if asynchronous:
            self._progress(True)
        if not self._waits:
            self._say(DONE)

    def _nearest(self, flange: np.ndarray, joints: np.ndarray) -> np.ndarray:
        """The solution for (4, 4) that is closest to joints (6,); NaN where there is none."""
        ways = inverse(self.arm, flange[None]).joints[0]
        ways = joints + np.remainder(ways - joints + np.pi, 2 * np.pi) - np.pi
        return ways[np.nan_to_num(abs(ways - joints).max(axis=-1), nan=np.inf).argmin()]

"""The state of an emulated controller: what is asked of its registers, and where its arm is."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from devices.arm.kinematics import forward, links, pose_of, transform
from devices.emulated.ur.motion import Motion
from devices.emulated.ur.safety import Safety
from devices.emulated.ur.script import Script

# The controllers that most labs have: e-Series with 500 cycles a second, CB3 with 125.
E_SERIES, CB3 = ((5, 11, 1, 108318), 500.0), ((3, 15, 8, 106339), 125.0)


class Controller(Safety, Script):
    """An arm at rest, switched on and in remote control.

    clock: seconds of the controller. host_clock: seconds in which its clients' silence counts for the watchdog.
    stops: number of a move, counted from 1, and what interrupts it half way: see `Safety.interrupt`.
    """

    def __init__(
        self,
        model: str,
        joints: Sequence[float],
        clock: Callable[[], float],
        host_clock: Callable[[], float],
        stops: Mapping[int, str] | None = None,
    ) -> None:
        self.model, self.arm = model, links(model)
        self.version, self.hertz = E_SERIES if model.endswith("e") else CB3
        self.clock, self.host_clock = clock, host_clock
        self._start, self._said = np.array(joints, float), (None, {})
        self.restart()
        self.stops = dict(stops or {})

    def restart(self) -> None:
        """As it was in the beginning, with no stops to come."""
        self.at_rest, self.tool = self._start, np.zeros(6)
        self.motion: Motion | None = None
        self.stops: dict[int, str] = {}
        self.moves, self.stuck, self.stirred = 0, False, False
        self._interrupt_s: float | None = None
        self._as_of: float | None = None
        self.switch_on()
        self.clear_script()

    @property
    def now_s(self) -> float:
        """The time of what is happening."""
        return self.clock() if self._as_of is None else self._as_of

    def joints_now(self) -> tuple[np.ndarray, np.ndarray]:
        """Joints (6,) and their speeds."""
        if self.motion is None:
            return self.at_rest, np.zeros(6)
        return self.motion.at(self.clock())[:2]

    def pose_now(self) -> np.ndarray:
        """(6,) of the tool."""
        return self._poses(self.joints_now()[0])

    def _poses(self, joints: np.ndarray) -> np.ndarray:
        return pose_of(forward(self.arm, joints) @ transform(self.tool))

    def begin(self, motion: Motion) -> None:
        """Set off; a stop that is due during this move takes place half way."""
        self.moves += 1
        if self.moves in self.stops:
            self._interrupt_s = motion.began_s + motion.profile.lasts_s / 2
        self.motion = None if self.stuck else motion

    def brake(self, deceleration: float) -> None:
        """Come to rest along the path."""
        if self.motion is not None:
            self.motion = self.motion.brake(self.now_s, deceleration)

    def advance(self) -> None:
        """Let happen what is due."""
        now = self.clock()
        if self._interrupt_s is not None and now >= self._interrupt_s:
            # However late this is looked at, it happened when it was due.
            self._as_of, self._interrupt_s = self._interrupt_s, None
            self.interrupt(self.stops[self.moves])
            self._as_of = None
        self.watch()
        if self.motion is not None:
            joints, _, rests = self.motion.at(now)
            if rests:
                self.at_rest, self.motion = joints, None
        self.finish()

    def values(self) -> dict[str, Sequence[float]]:
        """What clients can ask for, by name; each a sequence."""
        self.advance()
        joints, speeds = self.joints_now()
        key = (joints.tobytes(), speeds.tobytes(), self.tool.tobytes())
        if self._said[0] != key:
            self._said = (key, self._kinematics(joints, speeds))
        return {
            **self._said[1],
            "timestamp": (self.clock(),),
            "stirred": (self.stirred,),
            "robot_mode": (self.robot_mode,),
            "safety_mode": (self.safety_mode,),
            "safety_status_bits": (self.safety_bits,),
            "robot_status_bits": (1 * self.powered + 2 * self.playing,),
            "runtime_state": (self.runtime_state,),
            "speed_scaling": (1.0,),
            "speed_scaling_combined": (1.0,),
            "target_speed_fraction": (1.0,),
            "joint_mode": (253,) * 6,
            **{f"output_int_register_{i}": (value,) for i, value in enumerate(self.output_ints)},
            **{f"output_double_register_{i}": (value,) for i, value in enumerate(self.output_doubles)},
        }

    def _kinematics(self, joints: np.ndarray, speeds: np.ndarray) -> dict[str, Sequence[float]]:
        step = 1e-5
        pose = self._poses(joints)
        velocity = np.zeros(6)
        if speeds.any():
            later = transform(self._poses(joints + step * speeds))
            velocity[:3] = (later[:3, 3] - pose[:3]) / step
            turned = np.eye(4)
            turned[:3, :3] = later[:3, :3] @ transform(pose)[:3, :3].T
            velocity[3:] = pose_of(turned)[3:] / step
        said = {"q": joints, "qd": speeds, "TCP_pose": pose, "TCP_speed": velocity}
        return {f"{kind}_{name}": row.tolist() for kind in ("actual", "target") for name, row in said.items()}

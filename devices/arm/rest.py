"""When an arm has come to rest, and where."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from devices.arm.link import Link
from devices.arm.stops import check_stops
from devices.captures import ArmStopped

# The arm rests when its tool is slower than this, for so many of the controller's states one after another.
STILL_M_S, STILL_RAD_S, STILL_STATES = 1e-3, 5e-3, 3
# A move begins a few cycles after it was asked for; who rests elsewhere for this long after it ended, or for this long
# while the controller still calls it a move (a speed slider at zero), does not get there: controller's seconds.
ENDED_S, HELD_S, ELSEWHERE_STATES = 0.5, 5.0, 60


@dataclass(frozen=True)
class Goal:
    """How close to where it was sent an arm has to rest."""

    metres: float
    radians: float

    def apart(self, pose: np.ndarray, target: np.ndarray) -> tuple[float, float]:
        """Metres and radians between poses (6,)."""
        turn = Rotation.from_rotvec(pose[3:]).inv() * Rotation.from_rotvec(target[3:])
        return float(np.linalg.norm(pose[:3] - target[:3])), float(turn.magnitude())

    def met(self, pose: np.ndarray, target: np.ndarray) -> bool:
        """Whether it is close enough."""
        if abs(pose[:3] - target[:3]).max() > self.metres:
            return False
        metres, radians = self.apart(pose, target)
        return metres <= self.metres and radians <= self.radians


def watched(link: Link, target: np.ndarray, goal: Goal) -> tuple[np.ndarray, np.ndarray]:
    """Wait until the tool rests at (6,); the pose and joints read back there.

    Raises `ArmStopped` where it was stopped, or rests elsewhere; `DeviceLost`.
    """
    there, elsewhere, elsewhere_since = 0, 0, np.inf
    while True:
        state = link.state()
        check_stops(link, state)
        still = np.linalg.norm(state.speed[:3]) < STILL_M_S and np.linalg.norm(state.speed[3:]) < STILL_RAD_S
        near = still and goal.met(state.pose, target)
        there = there + 1 if near else 0
        if there >= STILL_STATES and not state.operating:
            return state.pose, state.joints
        if near or not still:
            elsewhere, elsewhere_since = 0, np.inf
        else:
            elsewhere, elsewhere_since = elsewhere + 1, min(elsewhere_since, state.time_s)
        rested_s = state.time_s - elsewhere_since
        if elsewhere >= ELSEWHERE_STATES and rested_s >= (HELD_S if state.operating else ENDED_S):
            metres, radians = goal.apart(state.pose, target)
            raise ArmStopped(
                "not moved",
                f"the arm rests {1000 * metres:.1f} mm and {np.degrees(radians):.2f} degrees from where it was sent: "
                "see whether its speed slider is at zero or something holds it, then resume",
            )

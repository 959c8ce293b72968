"""Whether an arm gets through all poses of a scan in straight lines, before it moves at all."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from calibrate.rig import ArmSetup
from devices.arm.kinematics import BRANCHES, Solutions, forward, inverse, inverted, links, pose_of, transform
from recordings.refusal import Refusal

# Straight lines are looked at this often; between two samples no joint may turn by more than the last.
SAMPLE_M, SAMPLE_RAD, JUMP_RAD = 0.01, 0.05, np.radians(20)
# Closer to a singularity joints race, and the controller stops.
SINGULAR_RAD = np.radians(3)
NAMES = ("base", "shoulder", "elbow", "wrist 1", "wrist 2", "wrist 3")


@dataclass(frozen=True, eq=False)
class Path:
    """How the arm will go. joints: (K, 6) radians at each pose. metres: the tool's whole way, from where it stands."""

    joints: np.ndarray
    metres: float


def check_reach(poses: np.ndarray, setup: ArmSetup, start_joints: np.ndarray) -> Path:
    """The way from joints (6,), radians, through all poses (K, 6) of the tool, in straight lines, as moves go.

    The arm keeps its posture (branch) all along, and its joints turn steadily. `Refusal` names the first pose that it
    cannot get to, and why: too far, too near, at a joint's limit, or past a singularity.
    """
    arm, tool = links(setup.model), transform(np.array(setup.tool))
    start_joints, poses = np.asarray(start_joints, float), np.asarray(poses, float).reshape(-1, 6)
    start = pose_of(forward(arm, start_joints) @ tool)
    samples, leg = _samples(np.concatenate([start[None], poses]))
    solutions = inverse(arm, transform(samples) @ inverted(tool), start_joints[5])
    apart = abs(_turned(solutions.joints[0] - start_joints)).max(axis=-1)
    posture = int(np.nan_to_num(apart, nan=np.inf).argmin())
    limits = np.radians([setup.joint_low_deg, setup.joint_high_deg])
    joints, fault = _followed(solutions, posture, start_joints, limits, leg)
    if fault:
        others = (_followed(solutions, i, solutions.joints[0, i], limits, leg)[1] for i in range(len(BRANCHES)))
        hint = "; in another posture it does: move it there by hand" if None in others else ""
        at = _place(samples, leg, fault.at)
        raise Refusal(f"arm: {setup.model} does not get to {at}: {fault.why}{hint}")
    last = np.append(np.flatnonzero(np.diff(leg)), len(leg) - 1)
    steps = np.linalg.norm(np.diff(np.concatenate([start[None], poses])[:, :3], axis=0), axis=1)
    return Path(joints[last], float(steps.sum()))


@dataclass(frozen=True)
class _Fault:
    at: int
    why: str


def _samples(poses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Poses (N, 6) along the lines through (K + 1, 6), and the line (N,) of each; the first is the start itself."""
    turns = Rotation.from_rotvec(poses[:, 3:])
    along, turn = np.diff(poses[:, :3], axis=0), (turns[:-1].inv() * turns[1:]).as_rotvec()
    counts = np.maximum(np.linalg.norm(along, axis=1) / SAMPLE_M, np.linalg.norm(turn, axis=1) / SAMPLE_RAD)
    counts = np.maximum(np.ceil(counts - 1e-9), 1).astype(int)
    leg = np.repeat(np.arange(len(counts)), counts)
    share = (np.arange(len(leg)) - np.repeat(np.cumsum(counts) - counts, counts) + 1) / counts[leg]
    at = poses[leg, :3] + share[:, None] * along[leg]
    facing = (turns[leg] * Rotation.from_rotvec(share[:, None] * turn[leg])).as_rotvec()
    return np.concatenate([poses[:1], np.column_stack([at, facing])]), np.append(0, leg)


def _turned(angle: np.ndarray) -> np.ndarray:
    return np.remainder(angle + np.pi, 2 * np.pi) - np.pi


def _followed(
    solutions: Solutions, posture: int, start: np.ndarray, limits: np.ndarray, leg: np.ndarray
) -> tuple[np.ndarray, _Fault | None]:
    """Joints (N, 6) in one posture from the start on, and the first thing that is wrong with them."""
    path = solutions.joints[:, posture].copy()
    path[0] = start
    there = np.isfinite(path).all(axis=1)
    reached = len(path) if there.all() else int(there.argmin())
    path[:reached] = np.unwrap(path[:reached], axis=0)
    joints = path[:reached]
    turned = abs(np.diff(joints, axis=0, prepend=joints[:1]))
    from_wrist, from_elbow = (np.arcsin(np.minimum(abs(np.sin(joints[:, i])), 1)) for i in (4, 2))
    from_shoulder = np.arccos(np.minimum(solutions.shoulder[:reached, posture], 1))
    beyond = np.maximum(limits[0] - joints, joints - limits[1])
    checks = (
        (beyond.max(axis=1, initial=-np.inf) > 0, lambda i: _limit(joints[i], beyond[i], limits)),
        (from_wrist < SINGULAR_RAD, lambda i: _singular("joint 5", joints[i, 4], "turn the stand or tilt the patch")),
        (from_elbow < SINGULAR_RAD, lambda i: _singular("the elbow", joints[i, 2], "move the stand closer or farther")),
        (from_shoulder < SINGULAR_RAD, lambda i: "the wrist is right above the base: move the stand away from it"),
        (turned.max(axis=1, initial=0) > JUMP_RAD, lambda i: _jump(turned[i])),
    )
    faults = [_Fault(int(wrong.argmax()), why(int(wrong.argmax()))) for wrong, why in checks if wrong.any()]
    if reached < len(path):
        # What counts is how far the pose itself is, not where the way to it ends.
        end = reached + int(np.flatnonzero(leg[reached:] == leg[reached])[-1])
        faults.append(_Fault(reached, _missing(solutions, reached if there[end] else end, posture)))
    return path, min(faults, key=lambda fault: fault.at, default=None)


def _missing(solutions: Solutions, at: int, posture: int) -> str:
    millimetres = 1000 * solutions.missing_m[at, posture]
    if solutions.shoulder[at, posture] > 1:
        return f"it is {-millimetres:.0f} mm too close to the axis of the base"
    return f"it is {abs(millimetres):.0f} mm too {'far' if millimetres > 0 else 'near'}"


def _limit(joints: np.ndarray, beyond: np.ndarray, limits: np.ndarray) -> str:
    i = int(beyond.argmax())
    low, high = np.degrees(limits[:, i])
    return (
        f"joint {i + 1} ({NAMES[i]}) would be at {np.degrees(joints[i]):.0f} degrees, expected {low:.0f} to {high:.0f}"
    )


def _singular(what: str, angle: float, remedy: str) -> str:
    return f"{what} is at {np.degrees(_turned(angle)):.1f} degrees, a singularity where joints race: {remedy}"


def _jump(turned: np.ndarray) -> str:
    i = int(turned.argmax())
    return f"joint {i + 1} ({NAMES[i]}) would turn {np.degrees(turned[i]):.0f} degrees at once"


def _place(samples: np.ndarray, leg: np.ndarray, at: int) -> str:
    on_the_way = at + 1 < len(leg) and leg[at + 1] == leg[at]
    x, y, z = samples[at, :3]
    way = "on the way at " if on_the_way else ""
    return f"position {leg[at] + 1} of {leg[-1] + 1} ({way}x {x:.3f}, y {y:.3f}, z {z:.3f} m)"

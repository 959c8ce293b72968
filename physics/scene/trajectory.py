"""Where the camera is, when: poses from a file, or between a few that are given."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from recordings.refusal import Refusal
from recordings.relations import check_increasing, check_rigid
from recordings.untrusted import reading

# Quaternions of a few decimals are of length 1 to about this.
UNIT_TOLERANCE = 0.01


@dataclass(frozen=True, eq=False)
class Trajectory:
    """time_s: (F,) strictly increasing seconds. poses: (F, 4, 4) world from camera."""

    time_s: np.ndarray
    poses: np.ndarray

    def __post_init__(self) -> None:
        check_increasing("trajectory time", self.time_s)
        for i, pose in enumerate(self.poses):
            check_rigid(f"pose {i}", pose)

    def resampled(self, frames: int) -> "Trajectory":
        """`frames` poses evenly in time from the first to the last: straight lines, great arcs of rotation."""
        if len(self.time_s) == 1:
            still = np.repeat(self.poses, frames, axis=0)
            return Trajectory(self.time_s[0] + np.arange(frames) / 10, still)
        times = np.linspace(self.time_s[0], self.time_s[-1], frames)
        poses = np.tile(np.eye(4), (frames, 1, 1))
        poses[:, :3, :3] = Slerp(self.time_s, Rotation.from_matrix(self.poses[:, :3, :3]))(times).as_matrix()
        for axis in range(3):
            poses[:, axis, 3] = np.interp(times, self.time_s, self.poses[:, axis, 3])
        return Trajectory(times, poses)


def pose_of(position: np.ndarray, quaternion_xyzw: np.ndarray, place: str) -> np.ndarray:
    """(4, 4) world from camera."""
    length = float(np.linalg.norm(quaternion_xyzw))
    if not abs(length - 1) < UNIT_TOLERANCE:
        raise Refusal(f"{place}: the quaternion has length {length:.4g}, expected 1")
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_quat(quaternion_xyzw).as_matrix()
    pose[:3, 3] = position
    return pose


def looking_at(position: np.ndarray, target: np.ndarray, place: str) -> np.ndarray:
    """(4, 4) world from camera, where the world's y axis points down and the image is level."""
    forward = np.asarray(target, float) - position
    right = np.cross([0.0, 1.0, 0.0], forward)
    if not np.linalg.norm(right) > 1e-9:
        raise Refusal(f"{place}: looks straight up or down, or at itself; expected a quaternion there")
    forward, right = forward / np.linalg.norm(forward), right / np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3, :3] = np.stack([right, np.cross(forward, right), forward], axis=1)
    pose[:3, 3] = position
    return pose


def read_trajectory(path: str | Path) -> Trajectory:
    """Poses from text, a line each: time x y z qx qy qz qw, world from camera (the TUM RGB-D form); # comments."""
    path = Path(path)
    with reading(path, "list of poses"):
        lines = path.read_text(encoding="utf-8").splitlines()
        rows = [(n, line.split()) for n, line in enumerate(lines, 1) if line.strip() and not line.startswith("#")]
        times, poses = [], []
        for number, words in rows:
            if len(words) != 8:
                raise Refusal(f"line {number} has {len(words)} numbers, expected 8: time x y z qx qy qz qw")
            values = np.array(words, float)
            if not np.isfinite(values).all():
                raise Refusal(f"line {number} holds a number that is not finite, expected 8 finite ones")
            times.append(values[0])
            poses.append(pose_of(values[1:4], values[4:], f"line {number}"))
        if not rows:
            raise Refusal("holds no pose, expected at least one")
        return Trajectory(np.array(times), np.stack(poses))

"""Motions of an emulated arm: where its joints are at a time, and how it brakes."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from devices.arm.kinematics import Links, inverse, inverted, transform

# Between samples of a straight line the joints are interpolated; they are within a micrometre of it then.
SAMPLE_M, SAMPLE_RAD = 0.002, 0.005


@dataclass(frozen=True, eq=False)
class Profile:
    """Way along a path: stretches of constant acceleration. starts_s, way, speed, acceleration: (n,) at each start."""

    starts_s: np.ndarray
    way: np.ndarray
    speed: np.ndarray
    acceleration: np.ndarray

    def at(self, time_s: float) -> tuple[float, float]:
        """Way and speed at a time since the start."""
        i = max(int(np.searchsorted(self.starts_s, time_s, side="right")) - 1, 0)
        t = max(time_s - self.starts_s[i], 0.0)
        speed = self.speed[i] + self.acceleration[i] * t
        return float(self.way[i] + (self.speed[i] + speed) / 2 * t), float(speed)

    @property
    def lasts_s(self) -> float:
        """When it comes to rest."""
        return float(self.starts_s[-1])


def _profile(stretches: list[tuple[float, float]], way: float, speed: float) -> Profile:
    """A profile of (duration, acceleration) from a way and speed, which ends at rest."""
    rows, time = [], 0.0
    for lasts, acceleration in stretches:
        rows.append((time, way, speed, acceleration))
        time, way, speed = time + lasts, way + (speed + acceleration * lasts / 2) * lasts, speed + acceleration * lasts
    return Profile(*np.array([*rows, (time, way, 0.0, 0.0)]).T)


def trapezoid(length: float, speed: float, acceleration: float) -> Profile:
    """From rest to rest over a length, at most at `speed`."""
    speed = min(speed, np.sqrt(length * acceleration))
    ramp = speed / acceleration
    cruise = length / speed - ramp if speed > 0 else 0.0
    return _profile([(ramp, acceleration), (cruise, 0.0), (ramp, -acceleration)], 0.0, 0.0)


def braking(way: float, speed: float, acceleration: float) -> Profile:
    """To rest from a speed."""
    return _profile([(speed / acceleration, -acceleration)], way, speed)


@dataclass(frozen=True, eq=False)
class Motion:
    """A path, (n,) ways and (n, 6) joints, travelled by a profile that began at the controller's time `began_s`."""

    ways: np.ndarray
    joints: np.ndarray
    profile: Profile
    began_s: float

    def at(self, now_s: float) -> tuple[np.ndarray, np.ndarray, bool]:
        """Joints (6,), their speeds (6,), and whether it has come to rest."""
        way, speed = self.profile.at(now_s - self.began_s)
        i = int(np.clip(np.searchsorted(self.ways, way, side="right") - 1, 0, len(self.ways) - 2))
        step = self.ways[i + 1] - self.ways[i]
        share = min((way - self.ways[i]) / step, 1.0)
        slope = (self.joints[i + 1] - self.joints[i]) / step
        rests = now_s - self.began_s >= self.profile.lasts_s
        return self.joints[i] + share * step * slope, slope * (0.0 if rests else speed), rests

    def brake(self, now_s: float, acceleration: float) -> "Motion":
        """The same path, but to rest as soon as the acceleration allows; what was due to end sooner does."""
        way, speed = self.profile.at(now_s - self.began_s)
        sooner = braking(way, speed, acceleration)
        if sooner.way[-1] > self.ways[-1]:
            return self
        return Motion(self.ways, self.joints, sooner, now_s)


def straight(
    arm: Links,
    tool: np.ndarray,
    joints: np.ndarray,
    start: np.ndarray,
    pose: np.ndarray,
    speed: float,
    acceleration: float,
    now_s: float,
) -> Motion | None:
    """In a straight line from joints, where the tool is at (6,) `start`, to (6,) `pose`; None where no joints lead on.

    The tool turns evenly on the way. Speed counts metres of the tool, or radians where it turns more than it moves.
    """
    turn = Rotation.from_rotvec(start[3:]).inv() * Rotation.from_rotvec(pose[3:])
    metres, radians = float(np.linalg.norm(pose[:3] - start[:3])), float(turn.magnitude())
    length = max(metres, radians)
    if length < 1e-9:
        return Motion(np.array([0.0, 1e-9]), np.array([joints, joints]), trapezoid(0.0, speed, acceleration), now_s)
    n = int(np.ceil(max(metres / SAMPLE_M, radians / SAMPLE_RAD))) + 1
    share = np.linspace(0, 1, max(n, 2))
    poses = np.empty((len(share), 6))
    poses[:, :3] = start[:3] + share[:, None] * (pose[:3] - start[:3])
    poses[:, 3:] = (
        Rotation.from_rotvec(start[3:]) * Rotation.from_rotvec(share[:, None] * turn.as_rotvec())
    ).as_rotvec()
    ways = inverse(arm, transform(poses) @ inverted(transform(tool)), joints[5]).joints
    path = _followed(ways, joints)
    return None if path is None else Motion(share * length, path, trapezoid(length, speed, acceleration), now_s)


def _followed(solutions: np.ndarray, joints: np.ndarray) -> np.ndarray | None:
    """(n, 6) of the branch in (n, 8, 6) that begins at the joints, without turns by 360 degrees."""
    offset = np.remainder(solutions[0] - joints + np.pi, 2 * np.pi) - np.pi
    distance = np.nan_to_num(abs(offset).max(axis=-1), nan=np.inf)
    branch = int(distance.argmin())
    path = np.unwrap(np.concatenate([joints[None], solutions[1:, branch]]), axis=0)
    # At 2 mm a sample no joint turns far unless the arm passes a singularity, where the real one stops, too.
    usable = distance[branch] < 1e-3 and np.isfinite(path).all() and abs(np.diff(path, axis=0)).max() < 0.3
    return path if usable else None


def by_joints(joints: np.ndarray, target: np.ndarray, speed: float, acceleration: float, now_s: float) -> Motion:
    """All joints evenly from (6,) to (6,); the one that turns farthest has the speed, radians a second."""
    length = max(float(abs(target - joints).max()), 1e-9)
    return Motion(np.array([0.0, length]), np.array([joints, target]), trapezoid(length, speed, acceleration), now_s)

"""What the devices hand over, and what a scan asks of them; drivers and emulators agree on this and nothing else."""

from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np


@dataclass(frozen=True, eq=False)
class Measurement:
    """One whole measurement of a LiDAR: P zones of T bins.

    counts: (P, T) uint32, zones row-major in the sensor's own order. reference: (B, T) uint32 of the reference channel,
    one row for each burst. distance_mm, confidence: (P, 2) uint16 and uint8, what the chip itself found, 0 where it
    found nothing; None where the firmware does not say. temperature_c: of the chip, NaN where unknown.
    number: counts up by one for each measurement of the sensor, whether or not it got here. device_s: the sensor's own
    clock, seconds, NaN where it has none. host_s: seconds since the epoch at which its first line arrived.
    """

    counts: np.ndarray
    reference: np.ndarray
    distance_mm: np.ndarray | None
    confidence: np.ndarray | None
    temperature_c: float
    number: int
    device_s: float
    host_s: float


@dataclass(frozen=True, eq=False)
class Picture:
    """One frame of the camera.

    rgb: (H, W, 3) uint8. depth_m: (H, W) float32 aligned with it, NaN where unknown; None without a depth camera.
    device_s: the camera's clock, seconds. host_s: seconds since the epoch at which it arrived. number: counts up by one
    for each frame of the camera. said: exposure, gain, emitter and whatever else the camera reports of this frame.
    """

    rgb: np.ndarray
    depth_m: np.ndarray | None
    device_s: float
    host_s: float
    number: int
    said: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Settled:
    """Where the arm came to rest.

    pose: (6,) of the tool in the arm's base frame, metres and rotation vector, as read back. joints: (6,) radians.
    host_s: seconds since the epoch. moving_s: how long the motion took.
    """

    pose: np.ndarray
    joints: np.ndarray
    host_s: float
    moving_s: float


class Lidar(Protocol):
    """A sensor; `measure` may be called again and again."""

    said: dict[str, Any]  # firmware, mode, settings as read back, factory calibration

    def measure(self) -> Measurement:
        """A measurement all of which was taken after the call; raises `DeviceLost` where the sensor is gone."""

    def integrate(self) -> None:
        """Take one measurement; returns as soon as all of it is taken, for `read` to read; raises `DeviceLost`."""

    def read(self) -> Measurement | None:
        """The measurement that `integrate` took, None where part of it was lost on the way; raises `DeviceLost`."""

    def close(self) -> None:
        """Stop measuring and let go of the device."""


class Camera(Protocol):
    """A camera."""

    said: dict[str, Any]  # serial, firmware, intrinsics, extrinsics, depth scale

    def capture(self) -> Picture:
        """A frame exposed after the call; raises `DeviceLost` where the camera is gone."""

    def close(self) -> None:
        """Let go of the device."""


class Arm(Protocol):
    """A robot arm that carries the patch."""

    said: dict[str, Any]  # model, controller's version, serial number

    def move(self, pose: np.ndarray) -> Settled:
        """Move the tool in a straight line to (6,), wait until it rests; raises `ArmStopped`, `DeviceLost`."""

    def resume(self) -> None:
        """Wait until a stopped arm was released, and make it ready to move again; raises `DeviceLost`."""

    def stop(self) -> None:
        """Bring the arm to rest."""

    def close(self) -> None:
        """Bring the arm to rest and let go of it."""


class DeviceLost(Exception):
    """A device went away or does not answer; whoever asked may open it anew."""


class ArmStopped(Exception):
    """The arm was stopped: by protection, emergency, or a person; nothing moves until it is released.

    `kind` is "protective", "emergency", "program" or "not moved".
    """

    def __init__(self, kind: str, sentence: str) -> None:
        super().__init__(sentence)
        self.kind = kind

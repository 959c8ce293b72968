"""The three devices at one position of the arm: move, rest, measure and picture together."""

import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from devices.captures import Arm, ArmStopped, Camera, DeviceLost, Lidar, Measurement, Picture, Settled
from devices.scan.kept import Kept


@dataclass
class Tally:
    """Where the time of a scan goes, seconds, and what went wrong. stops: kind -> how often the arm was stopped."""

    moving_s: float = 0.0
    measuring_s: float = 0.0
    stops: dict[str, int] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Look:
    """What was seen at one position; `rgb` is of the last picture, None where none was wanted."""

    _before: list[tuple[Measurement, Picture | None]]
    _picture: Picture | None
    _reading: Future

    @property
    def rgb(self) -> np.ndarray | None:
        """(H, W, 3) uint8."""
        return None if self._picture is None else self._picture.rgb

    def read(self) -> list[tuple[Measurement, Picture | None]] | None:
        """Measurements with their pictures, once they are read out; None where the last was not whole."""
        measured = self._reading.result()
        return None if measured is None else [*self._before, (measured, self._picture)]


class Station:
    """Arm, LiDAR and camera, each opened again where it was lost.

    tell: hears in sentences what happens. settle_s: rest between motion and measurement.
    """

    def __init__(
        self,
        arm: Kept[Arm],
        lidar: Kept[Lidar],
        camera: Kept[Camera],
        settle_s: float,
        tell: Callable[[str], None],
    ) -> None:
        self.arm, self.lidar, self.camera = arm, lidar, camera
        self.tally, self._opened = Tally(), time.monotonic()
        self._settle_s, self._tell = settle_s, tell
        self._camera_side, self._lidar_side = ThreadPoolExecutor(1, "camera"), ThreadPoolExecutor(1, "LiDAR")

    def move(self, pose: np.ndarray) -> Settled:
        """Bring the tool to a pose (6,); where the arm is stopped on the way it waits for a person, then goes on."""
        while True:
            try:
                settled = self.arm.use(lambda arm: arm.move(pose))
                self.tally.moving_s += settled.moving_s
                if self._settle_s:
                    time.sleep(self._settle_s)
                return settled
            except ArmStopped as stopped:
                self.tally.stops[stopped.kind] = self.tally.stops.get(stopped.kind, 0) + 1
                why = str(stopped).rstrip(".")
                self._tell(f"{why}. The scan waits, and goes on by itself once the arm is released.")
                self.arm.use(lambda arm: arm.resume())
                self._tell("The arm is released; the scan goes on.")

    def see(self, repeats: int, pictures: bool) -> "Look":
        """Take measurements at rest, each with a picture taken meanwhile where these are wanted.

        Returns once the last is taken; it is read while the arm moves on, and may turn out not to be whole.
        """
        began = time.monotonic()
        seen: list[tuple[Measurement, Picture | None]] = []
        for left in reversed(range(repeats)):
            picture = self._camera_side.submit(self.picture) if pictures else None
            if left:
                seen.append((self.lidar.use(lambda lidar: lidar.measure()), picture and picture.result()))
            else:
                self.lidar.use(lambda lidar: lidar.integrate())
                reading = self._lidar_side.submit(self._read)
                last = picture and picture.result()
        self.tally.measuring_s += time.monotonic() - began
        return Look(seen, last, reading)

    def _read(self) -> Measurement | None:
        """The measurement that was taken; a sensor that was lost meanwhile has lost that, too."""
        try:
            return self.lidar.device.read()
        except DeviceLost as lost:
            self._tell(f"LiDAR: {lost}; the measurement will be taken again")
            self.lidar.lost += 1
            self.lidar.close()
            return None

    def picture(self) -> Picture:
        """A picture by itself."""
        return self.camera.use(lambda camera: camera.capture())

    def summary(self) -> dict[str, Any]:
        """Where the time went since the station was opened, and what went wrong, for the recording's meta."""
        whole = time.monotonic() - self._opened
        lost = {kept.what: kept.lost for kept in (self.arm, self.lidar, self.camera)}
        return asdict(self.tally) | {"whole_s": whole, "lost": lost}

    def close(self) -> None:
        """Bring the arm to rest first, then let go of everything."""
        for device in (self.arm, self.lidar, self.camera):
            device.close()
        for side in (self._camera_side, self._lidar_side):
            side.shutdown()

"""The three devices at one position of the arm: move, rest, measure and picture together."""

import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from devices.captures import Arm, ArmStopped, Camera, Lidar, Measurement, Picture, Settled
from devices.scan.kept import Kept


@dataclass
class Tally:
    """Where the time of a scan goes, seconds, and what went wrong. stops: kind -> how often the arm was stopped."""

    moving_s: float = 0.0
    measuring_s: float = 0.0
    stops: dict[str, int] = field(default_factory=dict)


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
        self._beside = ThreadPoolExecutor(1, "camera")

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

    def see(self, repeats: int, pictures: bool) -> list[tuple[Measurement, Picture | None]]:
        """Measurements at rest, each with a picture taken meanwhile where these are wanted."""
        began = time.monotonic()
        seen = []
        for _ in range(repeats):
            picture = self._beside.submit(self.picture) if pictures else None
            measured = self.lidar.use(lambda lidar: lidar.measure())
            seen.append((measured, picture and picture.result()))
        self.tally.measuring_s += time.monotonic() - began
        return seen

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
        self._beside.shutdown()

"""LiDAR and camera as one recording in passing, frame by frame as they come."""

import json
import threading
from collections import deque
from collections.abc import Iterator
from typing import Any

import numpy as np

from calibrate.rig import Rig
from devices.captures import Camera, DeviceLost, Picture
from devices.rig_static import rig_meta, rig_static
from devices.scan.kept import Kept
from devices.tmf882x.driver import Tmf882x
from physics.timing import LASER_HZ
from recordings.refusal import Refusal
from recordings.stream import Stream

# Pictures of the time that the slowest measurement takes, at the usual rate.
KEPT_PICTURES = 24
FIRST_PICTURE_S = 20.0


class Pictures:
    """The camera's latest pictures, taken in a thread from entering the context until leaving it."""

    def __init__(self, camera: Kept[Camera]) -> None:
        self._camera, self._latest = camera, deque[Picture](maxlen=KEPT_PICTURES)
        self._news, self._over = threading.Condition(), False
        self._failure: Exception | None = None
        self._thread = threading.Thread(target=self._take, name="pictures", daemon=True)

    def __enter__(self) -> "Pictures":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over = True
        self._thread.join()
        self._camera.close()

    def nearest(self, host_s: float) -> Picture:
        """The picture that came nearest to a time of the host; waits for the first. Raises what ended the camera."""
        with self._news:
            self._news.wait_for(lambda: self._latest or self._failure, FIRST_PICTURE_S)
            if self._failure is not None:
                raise self._failure
            if not self._latest:
                raise Refusal(f"the camera gave no picture for {FIRST_PICTURE_S:g} s; see to its cable")
            return min(self._latest, key=lambda picture: abs(picture.host_s - host_s))

    def _take(self) -> None:
        while not self._over:
            try:
                picture = self._camera.use(lambda camera: camera.capture())
            except (Refusal, DeviceLost, OSError) as failure:
                with self._news:
                    self._failure = failure
                    self._news.notify_all()
                return
            with self._news:
                self._latest.append(picture)
                self._news.notify_all()


def live_stream(rig: Rig, lidar: Tmf882x, camera: dict[str, Any], pictures: Pictures) -> Stream:
    """A stream without end: each measurement with the picture taken nearest to the middle of its integration.

    camera: what the camera said of itself.
    """
    meta = rig_meta(rig, lidar.said, camera, "live")
    static = rig_static(rig, lidar.said, camera) | {"meta_json": json.dumps(meta)}
    integration_s = float(static.get("laser_cycles", 0)) / LASER_HZ

    def frames() -> Iterator[dict[str, Any]]:
        last_s = -np.inf
        measured = lidar.frames()
        try:
            for measurement in measured:
                picture = pictures.nearest(measurement.host_s - integration_s / 2)
                if measurement.host_s <= last_s:  # the host's clock was set back
                    continue
                last_s = measurement.host_s
                frame = {"counts": measurement.counts, "timestamp_s": last_s, "rgb": picture.rgb}
                yield frame if picture.depth_m is None else frame | {"depth_m": picture.depth_m}
        finally:
            measured.close()

    return Stream(static, frames(), None)

"""Any camera that OpenCV opens: colour only, and what it does not say of itself is said to be unknown."""

import os
import time
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from calibrate.rig import CameraSetup
from devices.captures import DeviceLost, Picture
from recordings.refusal import Refusal

# Video4Linux under OpenCV fills four buffers when nobody reads, and one more frame may be under exposure.
STALE = 5
KEPT = ("EXPOSURE", "AUTO_EXPOSURE", "GAIN", "WB_TEMPERATURE", "AUTO_WB")


class OpenCvCamera:
    """A camera without depth; satisfies `Camera`.

    said: kind, backend, fps, `intrinsics` from the rig file or None, settings as read back.
    """

    def __init__(self, video: Any, setup: CameraSetup) -> None:
        self._video = video
        self._number = 0
        self.said = {
            "kind": setup.kind,
            "device": setup.device,
            "backend": video.getBackendName(),
            "fps": video.get(cv2.CAP_PROP_FPS),
            "intrinsics": pinhole(setup),
            "settings": {name.lower(): video.get(getattr(cv2, f"CAP_PROP_{name}")) for name in KEPT},
        }

    def capture(self) -> Picture:
        """A frame exposed after the call: those that may be older are read and dropped; raises `DeviceLost`."""
        for _ in range(STALE):
            self._number += 1
            if not self._video.grab():
                raise DeviceLost(f"camera {self.said['device'] or 0} sent no frame")
        read, bgr = self._video.read()
        arrived = time.time()
        if not read:
            raise DeviceLost(f"camera {self.said['device'] or 0} sent no frame")
        self._number += 1
        driver_ms = self._video.get(cv2.CAP_PROP_POS_MSEC)
        return Picture(
            rgb=cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB),
            depth_m=None,
            device_s=driver_ms / 1e3 if driver_ms > 0 else np.nan,
            host_s=arrived,
            number=self._number,
            said={"clock": "driver" if driver_ms > 0 else "none"},
        )

    def close(self) -> None:
        """Let go of the device."""
        self._video.release()


def open_opencv(setup: CameraSetup, opened: Any = cv2.VideoCapture) -> OpenCvCamera:
    """Open camera `setup.device` (an index, "" for 0, or an address); `Refusal` says what to do."""
    place = setup.device or "0"
    node = Path(f"/dev/video{place}" if place.isdecimal() else place)
    if node.exists() and not os.access(node, os.R_OK):
        raise Refusal(f"{node} may not be read by this user: add the user to the group video and log in again")
    video = opened(int(place) if place.isdecimal() else place)
    try:
        if not video.isOpened():
            here = ", ".join(str(path) for path in sorted(Path("/dev").glob("video*"))) or "none"
            raise Refusal(
                f"camera {place} does not open: plug it in, close other programs that use it, "
                f"set camera.device (video devices here: {here})"
            )
        for what, value in (
            (cv2.CAP_PROP_FRAME_WIDTH, setup.size[0]),
            (cv2.CAP_PROP_FRAME_HEIGHT, setup.size[1]),
            (cv2.CAP_PROP_FPS, setup.fps),
            (cv2.CAP_PROP_BUFFERSIZE, 1),
        ):
            video.set(what, value)
        _expose(video, setup.exposure_us)
        read, frame = video.read()
        if not read:
            raise Refusal(f"camera {place} opens but sends no frame: close other programs that use it")
        if frame.shape[1::-1] != tuple(setup.size):
            got = "x".join(map(str, frame.shape[1::-1]))
            asked = "x".join(map(str, setup.size))
            raise Refusal(f"camera {place} sends {got}, expected {asked}: set camera.size to a size that it has")
    except BaseException:
        video.release()
        raise
    return OpenCvCamera(video, setup)


def pinhole(setup: CameraSetup) -> dict[str, Any] | None:
    """The rig's own fx, fy, cx, cy in the form in which a RealSense says its lens; None where the rig has none."""
    if not setup.intrinsics:
        return None
    fx, fy, cx, cy = setup.intrinsics
    width, height = setup.size
    shape = {"width": width, "height": height, "fx": fx, "fy": fy, "ppx": cx, "ppy": cy}
    return shape | {"model": "none", "coeffs": [0.0] * 5}


def _expose(video: Any, exposure_us: int) -> None:
    if exposure_us:
        # Video4Linux: 1 is manual exposure, which is told in steps of 100 us (V4L2_CID_EXPOSURE_ABSOLUTE).
        video.set(cv2.CAP_PROP_AUTO_EXPOSURE, 1)
        video.set(cv2.CAP_PROP_EXPOSURE, exposure_us / 100)

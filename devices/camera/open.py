"""Open the camera that the rig file names."""

from typing import Any

import numpy as np

from calibrate.rig import CameraSetup
from devices.captures import Camera
from recordings.refusal import Refusal


def open_camera(setup: CameraSetup, timeout_s: float = 5.0) -> Camera:
    """The camera of the rig, streaming; `Refusal` says why it cannot be had and what to do.

    timeout_s: how long a frame may take before the camera counts as lost.
    """
    # Each kind loads its library when it is asked for, so that one that is not there harms no other.
    if setup.kind == "opencv":
        from devices.camera.opencv import open_opencv

        return open_opencv(setup)
    from devices.camera.realsense import RealSense

    if setup.kind == "rehearsed":
        from devices.emulated.camera import open_rehearsed

        source = open_rehearsed(setup, timeout_s)
    else:
        from devices.camera.pipeline import open_pipeline

        source = open_pipeline(setup)
    try:
        return RealSense(source, setup, timeout_s)
    except BaseException:
        source.close()
        raise


def camera_matrix(said: dict[str, Any]) -> np.ndarray:
    """(3, 3) intrinsic matrix, pixels, of a camera that said so; `Refusal` where neither it nor the rig file knows."""
    lens = said.get("intrinsics")
    if lens is None:
        raise Refusal("the camera does not know its lens, expected camera.intrinsics (fx, fy, cx, cy) in the rig file")
    return np.array([[lens["fx"], 0, lens["ppx"]], [0, lens["fy"], lens["ppy"]], [0, 0, 1.0]])

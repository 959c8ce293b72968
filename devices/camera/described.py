"""What a RealSense says of itself, as plain values for a recording's metadata."""

from typing import Any

import numpy as np
import pyrealsense2 as rs

from calibrate.rig import CameraSetup
from devices.camera.pipeline import said_by
from devices.camera.settings import settings
from devices.camera.source import Source

TEXTS = ("name", "serial_number", "firmware_version", "usb_type_descriptor", "product_line")
PROJECTOR_OFF = "off: the depth of surfaces without texture is poor"
PROJECTOR_ON = "on: its light (about 850 nm) leaks into the LiDAR and adds to its pedestal"
NO_PROJECTOR = "none"


def described(source: Source, setup: CameraSetup) -> dict[str, Any]:
    """Identity, lenses, where depth and colour sit to one another, depth unit and every setting as read back.

    `depth_to_colour` maps points: colour = rotation (3, 3) @ depth + translation, metres.
    """
    device = source.device
    said = {name: said_by(device, getattr(rs.camera_info, name)) for name in TEXTS}
    options = settings(device)
    emitter = [have["emitter_enabled"] for have in options.values() if "emitter_enabled" in have]
    said |= {
        "kind": setup.kind,
        "fps": source.colour.fps(),
        "intrinsics": lens(source.colour.get_intrinsics()),
        "settings": options,
        "projector": NO_PROJECTOR if not emitter else PROJECTOR_ON if emitter[0] else PROJECTOR_OFF,
    }
    if source.depth is not None:
        to_colour = source.depth.get_extrinsics_to(source.colour)
        # The SDK keeps matrices by columns (rs2_extrinsics in rs_sensor.h).
        said["depth_to_colour"] = {
            "rotation": np.reshape(to_colour.rotation, (3, 3)).T.tolist(),
            "translation": list(to_colour.translation),
        }
        said["depth_intrinsics"] = lens(source.depth.get_intrinsics())
        said["depth_scale_m"] = device.first_depth_sensor().get_depth_scale()
    return said


def lens(intrinsics: Any) -> dict[str, Any]:
    """Focal lengths and centre in pixels, distortion as the SDK models it."""
    return {
        "width": intrinsics.width,
        "height": intrinsics.height,
        "fx": intrinsics.fx,
        "fy": intrinsics.fy,
        "ppx": intrinsics.ppx,
        "ppy": intrinsics.ppy,
        "model": intrinsics.model.name,
        "coeffs": list(intrinsics.coeffs),
    }

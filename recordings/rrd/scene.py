"""What the viewer needs beside the data: the camera, the poses, the formats of images; rounded, never read back."""

from typing import Any

import numpy as np
import rerun as rr

from recordings.rrd.layout import SHOWN, Layout, place

KINDS = {"rgb": rr.EncodedImage, "depth_m": rr.DepthImage}


def image_kind(name: str) -> Any:
    """The viewer's archetype of an image field."""
    return KINDS.get(name, rr.Image)


def send_scene(recording: rr.RecordingStream, static: dict[str, Any], layout: Layout) -> None:
    """Log what holds for all frames."""
    recording.log("/", rr.ViewCoordinates.RDF, static=True, strict=True)
    images = {name: kept for name, kept in {**layout.static, **layout.frames}.items() if name in SHOWN}
    for name, kept in images.items():
        if name in ("rgb", "meta_json"):
            continue
        height, width = kept.shape
        channel = rr.ChannelDatatype.from_np_dtype(kept.dtype)
        form = rr.components.ImageFormat(
            width=width, height=height, color_model=rr.ColorModel.L, channel_datatype=channel
        )
        more = {"meter": 1.0} if name == "depth_m" else {}
        columns = image_kind(name).columns(format=form, **more)
        recording.send_columns(place(name)[0], [], columns, strict=True)
    if "intrinsics" in static and "image_size" in static:
        # The viewer counts from the corner of the first pixel, this project from its centre.
        matrix = np.add(static["intrinsics"], [[0, 0, 0.5], [0, 0, 0.5], [0, 0, 0]])
        pinhole = rr.Pinhole(image_from_camera=matrix, resolution=static["image_size"])
        recording.log("camera", pinhole, static=True, strict=True)
    if "lidar_from_camera" in static:
        recording.log("camera/lidar", transform(np.linalg.inv(static["lidar_from_camera"])), static=True, strict=True)


def transform(pose: np.ndarray) -> rr.Transform3D:
    """A (4, 4) rigid transform as the viewer takes it."""
    return rr.Transform3D(translation=pose[:3, 3], mat3x3=pose[:3, :3])


def send_poses(recording: rr.RecordingStream, times: list, moving: dict[str, list[Any]]) -> None:
    """Log where the camera is in each frame, where that is known."""
    if "camera_pose" in moving:
        poses = np.stack(moving["camera_pose"]).astype(np.float32)
        columns = rr.Transform3D.columns(translation=poses[:, :3, 3], mat3x3=poses[:, :3, :3])
        recording.send_columns("camera", times, columns, strict=True)

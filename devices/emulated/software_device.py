"""The parts of a software RealSense: lenses, streams and options as a D435i has them."""

from typing import Any

import numpy as np
import pyrealsense2 as rs

UNIT_M = 1e-3  # of a depth count, as on the D400
# The SDK's alignment rounds the corners of each depth pixel; where both cameras have one place and one lens, every
# hundredth column would get none. Depth pixels that are this much wider close the gaps, and shift nothing by 0.01 px.
WIDER = 2e-5

# Options that the driver sets: name, lowest, highest and usual value; those of the D435i.
OF_DEPTH = (("emitter_enabled", 0, 2, 1), ("laser_power", 0, 360, 150), ("asic_temperature", 0, 125, 40))
OF_COLOUR = (
    ("enable_auto_exposure", 0, 1, 1),
    ("exposure", 1, 10000, 156),
    ("gain", 0, 128, 64),
    ("auto_exposure_priority", 0, 1, 0),
)


def lens_of(size: tuple[int, int], intrinsics: tuple[float, ...]) -> Any:
    """An ideal lens of fx, fy, cx, cy in pixels, or a usual one for ()."""
    width, height = size
    # Without a lens of its own, 69 degrees across: the D435's colour sensor by its datasheet.
    usual = width / 2 / np.tan(np.radians(69) / 2)
    fx, fy, cx, cy = intrinsics or (usual, usual, (width - 1) / 2, (height - 1) / 2)
    lens = rs.intrinsics()
    lens.width, lens.height, lens.fx, lens.fy, lens.ppx, lens.ppy = width, height, fx, fy, cx, cy
    lens.model, lens.coeffs = rs.distortion.none, [0.0] * 5
    return lens


def wider(lens: Any) -> Any:
    """The lens of the depth stream, see WIDER."""
    shorter = lens.fx * (1 - WIDER), lens.fy * (1 - WIDER)
    return lens_of((lens.width, lens.height), (*shorter, lens.ppx, lens.ppy))


def add_stream(sensor: Any, kind: Any, pixel: Any, bytes_each: int, lens: Any, fps: int) -> Any:
    """The profile of a stream that is new to the sensor; kind and pixel of rs.stream and rs.format."""
    stream = rs.video_stream()
    stream.type, stream.fmt, stream.bpp, stream.fps = kind, pixel, bytes_each, fps
    stream.index, stream.uid = 0, int(kind)
    stream.width, stream.height, stream.intrinsics = lens.width, lens.height, lens
    return sensor.add_video_stream(stream).as_video_stream_profile()


def add_options(sensor: Any, options: tuple[tuple[str, int, int, int], ...]) -> None:
    """Give the sensor options that may be set."""
    for name, low, high, usual in options:
        can = rs.option_range()
        can.min, can.max, can.step, can.default = low, high, 1, usual
        sensor.add_option(getattr(rs.option, name), can, True)

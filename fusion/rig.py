"""The camera grid of a recording, and what fusion needs to know of the rig that made it."""

import itertools
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from fusion.range_response import RangeResponse, range_response
from fusion.sight import Sight, sight
from physics.scene.camera import camera_of
from physics.sensor import SensorModel
from physics.sensor_choice import choose_sensor
from recordings.encoded import encoded_size
from recordings.files import stream
from recordings.maps import ResponseMaps
from recordings.refusal import Refusal
from recordings.stream import Stream

# A clock is off by a few hundredths; bins that differ by more are those of another range mode.
MOST_CLOCK_ERROR = 0.1


def open_rig(
    path: str | Path, maps: ResponseMaps, sensor_name: str | None = None
) -> tuple[Stream, Sight, RangeResponse]:
    """A recording in passing, checked frame by frame, with sight and response of its rig.

    sensor_name: a sensor.json or a preset; where None, the sensor that the recording says it was made with, or the
    TMF8828 in the mode of the maps for published files that say nothing. Raises `Refusal`.
    """
    passing = stream(path)
    frames = passing.checked()
    first = next(frames, None)
    if first is None:
        raise Refusal(f"{path}: has no frame, expected at least one")
    if sensor_name is None and passing.static.get("irf") is not None:
        # One frame says it, and the others need not be read for it.
        sensor = SensorModel.of(Stream(passing.static, iter([first]), 1).collect())
    else:
        sensor = choose_sensor(sensor_name, path, maps)
    return replace(passing, frames=itertools.chain([first], frames)), *rig_of(passing.static, first, maps, sensor)


def rig_of(
    static: dict[str, Any], first: dict[str, Any], maps: ResponseMaps, sensor: SensorModel
) -> tuple[Sight, RangeResponse]:
    """Where zones look on the recording's camera grid, and how the sensor counts.

    static, first: fields of a `Stream` and of its first frame. A recording without a camera is fused on a grid over the
    field of the maps. Raises `Refusal` where recording, maps and sensor do not fit together.
    """
    zones, bins = tuple(int(n) for n in static["zone_grid"]), first["counts"].shape[-1]
    for name, other in (("the response maps have", maps.zone_grid), ("the sensor has", tuple(sensor.zone_grid))):
        if tuple(other) != zones:
            there, here = (" x ".join(str(n) for n in grid) for grid in (other, zones))
            raise Refusal(f"{name} {there} zones but the recording {here}, expected the same")
    if bins != sensor.bins:
        raise Refusal(f"the sensor has {sensor.bins} bins but the recording {bins}, expected the same")
    width = float(static["bin_width_s"])
    if abs(width / sensor.bin_width_s - 1) > MOST_CLOCK_ERROR:
        widths = f"{sensor.bin_width_s:.4g} s wide but the recording's {width:.4g} s"
        raise Refusal(f"the sensor's bins are {widths}, expected the same range mode")
    shape, intrinsics = image_shape(static, first), static.get("intrinsics")
    if shape is None:
        intrinsics, size = camera_of(maps)
        shape = size[::-1]
    elif intrinsics is None:
        raise Refusal("intrinsics is missing, expected the pinhole matrix of the recording's camera")
    where = sight(
        maps,
        shape,
        np.asarray(intrinsics, float),
        static.get("lidar_from_camera"),
        effects=sensor.effects,
        calibration_range_m=json.loads(static.get("meta_json", "{}")).get("calibration_range_m"),
    )
    return where, range_response(sensor)


def image_shape(static: dict[str, Any], first: dict[str, Any]) -> tuple[int, int] | None:
    """(H, W) of the recording's camera grid, None where it has none."""
    rgb = given(first, static, "rgb")
    if isinstance(rgb, bytes):
        return encoded_size(rgb, "rgb")
    for image in (rgb, given(first, static, "depth_m")):
        if image is not None:
            return tuple(image.shape[:2])
    size = static.get("image_size")
    return None if size is None else (int(size[1]), int(size[0]))


def given(frame: dict[str, Any], static: dict[str, Any], name: str) -> Any:
    """A field of this frame, or the one that holds for all; None where there is none."""
    return frame.get(name, static.get(name))

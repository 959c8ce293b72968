"""What `difflidar view` shows of a recording: its frames, fused and simulated as far as what is given allows."""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.constants import speed_of_light

from fusion.depths import zone_depths
from fusion.fuse import expect_method, fuse_frame
from fusion.motion import Earlier
from fusion.mount import mounted
from fusion.range_response import RangeResponse, range_response
from fusion.rig import given, rig_of
from fusion.sight import Sight
from fusion.zone_view import ZoneDepths
from physics.nominal import ForwardModel
from physics.scene.view import View
from physics.sensor import SensorModel
from physics.sensor_choice import choose_sensor
from physics.simulate import light_of
from recordings.files import load, stream
from recordings.maps import ResponseMaps
from recordings.maps_file import load_maps
from recordings.refusal import Refusal
from recordings.stream import Stream
from viewers.session_frame import SessionFrame, SessionRig

HOW_TO_READ = (
    "**Histograms**: photon counts by range in millimetres, a panel for each zone, each lying where the zone looks; "
    "white bars mark the surfaces that were fitted, as high as their share of the light.",
    "**Camera**: lines run where a zone sees half as well as where it sees best.",
    "**Depth** is along the camera's axis, blue near, red far; the uncertainty is its standard error. "
    "Hover for values in metres.",
    "**Residual**: recorded less simulated, in standard deviations of photon noise, cyan to yellow from −6 to 6; "
    "the simulation sees the camera's depth through the maps, and its brightness is fitted in every frame.",
)


@dataclass(frozen=True, eq=False)
class Instruments:
    """What is known of the rig; None where nobody said.

    sensor, response: how it counts, without maps where the recording carries its impulse response. sight: where the
    zones look. method: of fusion. effects: of the sensor, parallax as in the sight among them.
    """

    sensor: SensorModel | None = None
    response: RangeResponse | None = None
    sight: Sight | None = None
    method: str = ""
    effects: tuple = ()


def open_recording(
    path: Path, maps_path: Path | None, sensor_name: str | None, method: str
) -> tuple[SessionRig, Iterator[SessionFrame], int | None]:
    """The rig of a recording, its frames as they are computed, and how many there will be (None if unknown)."""
    passing = stream(path)
    frames = passing.checked()
    first = next(frames, None)
    if first is None:
        raise Refusal(f"{path}: has no frame, expected at least one")
    tools = _instruments(path, passing.static, first, maps_path, sensor_name, method)
    passing = replace(passing, frames=itertools.chain([first], frames))
    return session_of(passing, path.stem, _said(path, passing.count, tools), tools)


def session_of(
    passing: Stream, title: str, said: str, tools: Instruments
) -> tuple[SessionRig, Iterator[SessionFrame], int | None]:
    """Rig and frames of a stream of at least one frame, already checked; `said` is the first sentence to read."""
    frames, static = passing.frames, passing.static
    first = next(frames)
    zones, bins = first["counts"].shape
    time_zero = np.broadcast_to(np.asarray(static["time_zero_s"], float), zones)
    arrival = (np.arange(bins) + 0.5) * float(static["bin_width_s"])
    has_depth = given(first, static, "depth_m") is not None
    rig = SessionRig(
        tuple(int(n) for n in static["zone_grid"]),
        (arrival - time_zero[:, None]) * speed_of_light / 2,
        None if tools.sight is None else tools.sight.normalised,
        title=title,
        sentences=(said, *HOW_TO_READ),
        start_s=float(first["timestamp_s"]),
        first_pose=first.get("camera_pose"),
        has_pictures=given(first, static, "rgb") is not None,
        has_depth=tools.sight is not None,
        has_residuals=tools.sight is not None and has_depth,
        has_recorded_depth=has_depth,
    )
    earlier = None if tools.sight is None else Earlier(tools.sight)
    return rig, (_frame(frame, static, tools, earlier) for frame in itertools.chain([first], frames)), passing.count


def _instruments(
    path: Path,
    static: dict[str, Any],
    first: dict[str, Any],
    maps_path: Path | None,
    sensor_name: str | None,
    method: str,
) -> Instruments:
    if maps_path is None:
        if sensor_name is not None:
            raise Refusal(f"the sensor {sensor_name} without response maps, expected --calibration MAPS beside it")
        if static.get("irf") is None:
            return Instruments()
        sensor = SensorModel.of(load(path))
        return Instruments(sensor, range_response(sensor))
    expect_method(method)
    maps = load_maps(maps_path)
    return instruments(static, first, maps, choose_sensor(sensor_name, path, maps), method)


def instruments(
    static: dict[str, Any], first: dict[str, Any], maps: ResponseMaps, sensor: SensorModel, method: str
) -> Instruments:
    """What it takes to fuse frames of a rig."""
    where, response = rig_of(static, first, maps, sensor)
    effects = mounted(sensor, maps, static.get("lidar_from_camera")).effects
    return Instruments(sensor, response, where, method, effects)


def _said(path: Path, count: int | None, tools: Instruments) -> str:
    """What was looked at, and how."""
    how = f", fused by the method *{tools.method}*" if tools.sight is not None else ""
    sensor = f", {tools.sensor.name} {tools.sensor.mode}".rstrip() if tools.sensor and tools.sensor.name else ""
    return f"{path.name}{sensor}: {count or 'some'} frames{how}."


def _frame(frame: dict[str, Any], static: dict[str, Any], tools: Instruments, earlier: Earlier | None) -> SessionFrame:
    """One frame as the session shows it; earlier: the views before it, None where frames are not fused."""
    rgb, depth, pose = given(frame, static, "rgb"), given(frame, static, "depth_m"), frame.get("camera_pose")
    made = SessionFrame(
        float(frame["timestamp_s"]),
        frame["counts"],
        rgb=rgb,
        intrinsics=static.get("intrinsics"),
        pose=pose,
        recorded_depth_m=depth,
    )
    if tools.response is None:
        return made
    seen = zone_depths(frame["counts"], tools.response)
    made = replace(made, surface_m=seen.surface_m, surface_share=_share(seen))
    if tools.sight is None or earlier is None:
        return made
    fused = fuse_frame(
        frame["counts"],
        rgb,
        tools.sight,
        tools.response,
        tools.method,
        timestamp_s=made.timestamp_s,
        pose=pose,
        depths=seen,
        motion=earlier.motion(pose, seen.typical_m),
    )
    earlier.add(fused.rgb, pose, seen.typical_m)
    expected = None if depth is None else _expected(frame, static, depth, tools)
    return replace(made, fused=fused, expected=expected)


def _share(seen: ZoneDepths) -> np.ndarray:
    """(P, S) of the light that a zone's surfaces send back."""
    total = np.nansum(seen.surface_counts, axis=-1, keepdims=True)
    return seen.surface_counts / np.where(total > 0, total, 1)


def _expected(frame: dict[str, Any], static: dict[str, Any], depth: np.ndarray, tools: Instruments) -> np.ndarray:
    """(P, T) counts that the model expects of the camera's depth, as bright all in all as what was recorded."""
    counts = np.asarray(frame["counts"], float)
    images = {name: given(frame, static, name) for name in ("reflectance", "incidence_cosine")}
    view = View(float(frame["timestamp_s"]), np.asarray(depth), **images)
    light = light_of([view], tools.sight.intrinsics, tools.sensor, view.timestamp_s)
    level = np.asarray(tools.sensor.background_counts, float)[:, None]
    model = ForwardModel(light, tools.sight.footprints, tools.sensor.clock, level[:, 0])
    signal = float((model.expected(1.0, tools.effects)[0] - level).sum())
    gain = float((counts - level).sum()) / signal if signal > 0 else 0.0
    return model.expected(gain, tools.effects)[0] if gain > 0 else np.broadcast_to(level, counts.shape)

"""A scene becomes a recording: views in, expected counts, drawn photons out; a few frames at a time."""

import itertools
import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from physics.footprint import Footprints, footprints
from physics.light import Light, Return, direct_light
from physics.motion import Motion
from physics.nominal import ForwardModel
from physics.photons import draw_counts
from physics.scene.view import View, Views
from physics.scene.windows import windows
from physics.sensor import SensorModel
from physics.sensor_file import sensor_to_json
from recordings.maps import ResponseMaps
from recordings.refusal import Refusal
from recordings.stream import Stream

# A batch holds so many pixels and so many frames at most, whatever the length of the recording.
BATCH_PIXELS = 1 << 22
BATCH_FRAMES = 32


@dataclass
class Tally:
    """What has passed so far: pixels, and how many of them contributed nothing because something is unknown there."""

    pixels: int = 0
    missing: int = 0


def simulate(
    views: Views,
    maps: ResponseMaps,
    sensor: SensorModel,
    rng: np.random.Generator,
    *,
    gain: float | None = None,
    peak: float = 1000.0,
) -> tuple[Stream, Tally]:
    """What `sensor`, looking where `maps` say, would record of the scene; the same state of `rng` gives the same.

    gain: counts per unit of light; where None, such that the fullest bin of the first frame holds `peak` counts of
    signal before the sensor's effects. The recording is to be run through once; the tally is kept while it is.
    Raises `Refusal` where scene, maps and sensor do not fit together.
    """
    if maps.zone_grid != tuple(sensor.zone_grid):
        there, here = (" x ".join(str(n) for n in grid) for grid in (maps.zone_grid, sensor.zone_grid))
        raise Refusal(f"the response maps have {there} zones but the sensor {here}, expected the same")
    for name, value in (("gain", gain), ("peak", peak)):
        if value is not None and not (np.isfinite(value) and value > 0):
            raise Refusal(f"{name} is {value}, expected a finite number above 0")
    first = next(views.views, None)
    if first is None:
        raise Refusal("the scene has no view, expected at least one")
    where = footprints(maps, first.depth_m.shape, views.meta.get("calibration_range_m"))
    if np.isfinite(where.calibration_range_m):
        views = replace(views, meta=views.meta | {"calibration_range_m": where.calibration_range_m})
    if gain is None:
        light = light_of([first], views.intrinsics, sensor, first.timestamp_s)
        fullest = float(ForwardModel(light, where, sensor.clock).expected().max())
        if not fullest > 0:
            raise Refusal("no light of the first frame falls into any bin, expected some, or that the gain is given")
        gain = peak / fullest
    everything = replace(views, views=itertools.chain([first], views.views))
    tally = Tally()
    frames = _frames(everything, where, sensor, gain, first, rng, tally)
    return Stream(_static(views, first, sensor, gain), frames, views.count), tally


def light_of(
    batch: list[View],
    intrinsics: np.ndarray,
    sensor: SensorModel,
    start_s: float,
    first_frame: int = 0,
    start_pose: np.ndarray | None = None,
) -> Light:
    """What the scene sends back in a batch of views from `first_frame` on; the session began at `start_s`.

    start_pose: (4, 4) of the camera then, world from camera; where None that of the first view.
    """
    depth, reflectance, cosine, gloss = (
        None if getattr(batch[0], name) is None else np.stack([getattr(view, name) for view in batch])
        for name in ("depth_m", "reflectance", "incidence_cosine", "gloss")
    )
    times = np.array([view.timestamp_s for view in batch]) - start_s
    poses = [view.camera_pose for view in batch]
    known = all(pose is not None for pose in poses)
    light = direct_light(
        depth,
        intrinsics,
        reflectance,
        cosine,
        time_s=times,
        laser_cycles=sensor.laser_cycles,
        first_frame=first_frame,
        motion=Motion.of(times, np.stack(poses), start_pose) if known else None,
    )
    if gloss is None:
        return light
    direct = light.returns[0]
    return replace(light, returns=(Return(direct.range_m, direct.strength * np.nan_to_num(gloss)),))


def _frames(
    scene: Views,
    where: Footprints,
    sensor: SensorModel,
    gain: float,
    start: View,
    rng: np.random.Generator,
    tally: Tally,
) -> Iterator[dict[str, Any]]:
    """Frames of the recording; the model sees a batch with as many frames around it as the effects look at."""
    grid, clock = where.x_px.shape, sensor.clock
    size = max(1, min(BATCH_FRAMES, BATCH_PIXELS // (grid[0] * grid[1])))
    reaches = [setting.effect.reach(setting.values) for setting in sensor.effects]
    done = 0
    for around, batch in windows(_on_grid(scene.views, grid), size, start.timestamp_s, reaches):
        sent = (scene.intrinsics, sensor, start.timestamp_s, done - batch.start, start.camera_pose)
        light = light_of(around, *sent)
        done += batch.stop - batch.start
        model = ForwardModel(light, where, clock, sensor.background_counts)
        counts = draw_counts(model.expected(gain, sensor.effects)[batch], rng)
        tally.pixels += light.range_m[batch].size
        tally.missing += int(light.missing[batch].sum())
        for view, cosine, seen in zip(around[batch], light.cosine[batch], counts, strict=True):
            images = {"depth_m": view.depth_m, "reflectance": view.reflectance, "incidence_cosine": cosine}
            rest = {"rgb": view.rgb, "camera_pose": view.camera_pose}
            frame = {"counts": seen, "timestamp_s": view.timestamp_s, **images, **rest}
            yield {name: value for name, value in frame.items() if value is not None}


def _on_grid(views: Iterator[View], grid: tuple[int, int]) -> Iterator[View]:
    """The views, refused where one has another grid than the first."""
    for i, view in enumerate(views):
        if view.depth_m.shape != grid:
            found = f"depth_m[{i}] has shape {view.depth_m.shape}"
            raise Refusal(f"{found}, expected {grid} as in the first frame")
        yield view


def _static(views: Views, first: View, sensor: SensorModel, gain: float) -> dict[str, Any]:
    """Fields of the recording that hold for all frames."""
    pulse, described = sensor.clock.pulse, sensor_to_json(sensor)
    meta = {
        **views.meta,
        "sensor": sensor.name,
        "mode": sensor.mode,
        "made_by": "difflidar simulate",
        "gain": gain,
        "effects": described["effects"],
    }
    fields = {
        "zone_grid": np.array(sensor.zone_grid),
        "bin_width_s": np.float64(sensor.bin_width_s),
        "time_zero_s": np.array(sensor.time_zero_s),
        "irf_time_s": pulse.time_s,
        "irf": pulse.probability,
        "background_counts": np.array(sensor.background_counts),
        "laser_cycles": None if sensor.laser_cycles is None else np.int64(sensor.laser_cycles),
        "intrinsics": views.intrinsics,
        "image_size": np.array(first.depth_m.shape[::-1]),
        "lidar_from_camera": views.lidar_from_camera,
        "meta_json": json.dumps(meta),
    }
    return {name: value for name, value in fields.items() if value is not None}

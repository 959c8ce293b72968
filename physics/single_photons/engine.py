"""Photons one by one: what a sensor counts, each photon followed from its pixel to its bin.

The oracle of the fast engine (`physics.nominal`): the two share data classes and the effects' definitions, no formula.
"""

import json
from collections.abc import Iterator
from dataclasses import replace
from types import ModuleType
from typing import Any

import numpy as np

from physics.effect import Values
from physics.scene.view import Views
from physics.sensor import SensorModel
from physics.sensor_file import sensor_to_json
from physics.setting import Setting, in_order
from physics.single_photons.acts import find_act
from physics.single_photons.draw import background, counts_of, returned
from physics.single_photons.session import Session, session_of
from physics.single_photons.world import Photons, World
from recordings.maps import ResponseMaps
from recordings.recording import Recording
from recordings.refusal import Refusal
from recordings.stream import Stream


def draw_frame(world: World, effects: tuple[Setting, ...], rng: np.random.Generator) -> np.ndarray:
    """(P, T) int64 counts of one frame. Raises `Refusal` where an effect has no act on single photons."""
    now = (effect.times(float(effect.degree(world.time_s))) if effect.grows else effect for effect in effects)
    there = in_order(tuple(effect for effect in now if effect.since_s <= world.time_s))
    acting = [(find_act(setting.effect.id), setting.values) for setting in there]
    for act, values in acting:
        if hasattr(act, "world"):
            world = _met(act, world, values, rng)

    def through(hook: str, thing: Any) -> Any:
        for act, values in acting:
            if hasattr(act, hook):
                thing = getattr(act, hook)(thing, world, values, rng)
        return thing

    photons = through("photons", returned(world, rng)).and_also(background(world, rng))
    photons = through("detected", _with_shots(photons, world, rng))
    return through("counted", counts_of(photons, world))


def draw_frames(session: Session, rng: np.random.Generator) -> Iterator[np.ndarray]:
    """(P, T) counts of each frame of a session, with the effects of its sensor."""
    for i in range(len(session.views)):
        yield draw_frame(session.world(i), session.sensor.effects, rng)


def photon_counts(
    views: Views, maps: ResponseMaps, sensor: SensorModel, rng: np.random.Generator, gain: float
) -> np.ndarray:
    """(F, P, T) int64 counts of all views; the same state of `rng` gives the same."""
    return np.stack(list(draw_frames(session_of(views, maps, sensor, gain), rng)))


def record(views: Views, maps: ResponseMaps, sensor: SensorModel, rng: np.random.Generator, gain: float) -> Recording:
    """What `sensor`, looking where `maps` say, would record of the scene: a recording with all that it was made from.

    gain: counts per unit of light. The views are held in memory, for effects that look at other frames; photons only
    of one frame at a time.
    """
    session = session_of(views, maps, sensor, gain)
    return Stream(_static(views, session), _frames(session, rng), len(session.views)).collect()


def _met(act: ModuleType, world: World, values: Values, rng: np.random.Generator) -> World:
    """The world after an act, and other frames of it as they are after the same act."""
    before = world.at
    return replace(act.world(world, values, rng), at=lambda time_s: act.world(before(time_s), values, rng))


def _with_shots(photons: Photons, world: World, rng: np.random.Generator) -> Photons:
    """The photons, each of a laser shot of the frame: all shots are alike."""
    if world.laser_cycles is None:
        return photons
    shot = rng.integers(world.laser_cycles, size=len(photons), dtype=np.int64)
    return replace(photons, shot=shot)


def _frames(session: Session, rng: np.random.Generator) -> Iterator[dict[str, Any]]:
    """Frames of the recording."""
    for i, (view, counts) in enumerate(zip(session.views, draw_frames(session, rng), strict=True)):
        if counts.max() > np.iinfo(np.uint32).max:
            raise Refusal(f"counts[{i}] reach {counts.max()}, expected at most {np.iinfo(np.uint32).max}")
        frame = {
            "counts": counts.astype(np.uint32),
            "timestamp_s": view.timestamp_s,
            "depth_m": view.depth_m,
            "reflectance": view.reflectance,
            "incidence_cosine": session.cosine(i).astype(np.float32),
            "rgb": view.rgb,
            "camera_pose": view.camera_pose,
        }
        yield {name: value for name, value in frame.items() if value is not None}


def _static(views: Views, session: Session) -> dict[str, Any]:
    """Fields of the recording that hold for all frames."""
    sensor, response = session.sensor, session.sensor.response
    meta = {
        **views.meta,
        "sensor": sensor.name,
        "mode": sensor.mode,
        "made_by": "difflidar, single photons",
        "gain": session.gain,
        "effects": sensor_to_json(sensor)["effects"],
    }
    fields = {
        "zone_grid": np.array(sensor.zone_grid),
        "bin_width_s": np.float64(sensor.bin_width_s),
        "time_zero_s": np.array(sensor.time_zero_s),
        "irf_time_s": response.time_s,
        "irf": response.probability,
        "background_counts": np.array(sensor.background_counts),
        "laser_cycles": None if sensor.laser_cycles is None else np.int64(sensor.laser_cycles),
        "intrinsics": views.intrinsics,
        "image_size": np.array(session.views[0].depth_m.shape[::-1]),
        "lidar_from_camera": views.lidar_from_camera,
        "meta_json": json.dumps(meta),
    }
    return {name: value for name, value in fields.items() if value is not None}

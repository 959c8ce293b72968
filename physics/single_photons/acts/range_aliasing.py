"""`range_aliasing`: photons of the shot before."""

from dataclasses import replace

import numpy as np
from scipy.constants import speed_of_light
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from physics.effect import Values
from physics.single_photons.draw import by_zone, pulse_from_elsewhere, returned
from physics.single_photons.where_from import start_from_camera
from physics.single_photons.world import Photons, World

# A wall that is turned away further than this, as cosine, is seen edge on.
EDGE_ON = 0.05
# Width of a thing's rim, as a part of half its size.
RIM = 0.1


def photons(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """A far target's, in view or not; each came after a laser period that was longer or shorter by a jitter of its
    own."""
    toward = [values["still_right"], values["still_down"], values["still"]]
    nearer = start_from_camera(world, "range_aliasing with still")[:3, 3] @ toward if any(toward) else 0.0
    there = by_zone(world, values["apparent_range"]) + world.time_s * values["speed"] - nearer
    there = there + _way_of_its_own(values, world.time_s)
    arrival_s = world.time_zero_s + 2 * there / speed_of_light
    counts, seen = by_zone(world, values["counts"]), world.weights.sum(axis=(1, 2))
    counts = counts * (1 - values["as_seen"] + values["as_seen"] * seen * world.zones / seen.sum())
    far = pulse_from_elsewhere(world, counts * world.boost, arrival_s, rng)
    period_s = values["period"]
    seen = returned(replace(world, gloss=world.gloss * values["folded"]), rng)
    for far_off in (_wall(world, values, "through"), _wall(world, values, "across"), _thing(world, values)):
        seen = seen.and_also(returned(far_off, rng))
    frame = int(np.argmin(np.abs(world.times_s - world.time_s)))
    late = frame % 2 if values["in_turn"] else rng.integers(0, 2, len(seen))
    since_s = period_s + late * values["stagger"] + values["smear"] * rng.standard_normal(len(seen))
    seen = replace(seen, time_s=seen.time_s - since_s)
    jitter_s = values["jitter"] * (2 * rng.random(len(far)) - 1) + values["spread"] * rng.standard_normal(len(far))
    return photons.and_also(seen).and_also(replace(far, time_s=far.time_s + jitter_s))


def _way_of_its_own(values: Values, time_s: float) -> float:
    """Metres by which a target that comes and goes is farther than at the start."""
    places = [0.0, *(values[f"level_{k}"] for k in range(1, 7))]
    beyond = [values[f"between_{k}"] for k in range(1, 7)]
    if not any(places + beyond):
        return 0.0
    times = values["every"] * np.arange(len(places))
    time_s, way = min(time_s, times[-1]), CubicSpline(times, places, bc_type="natural")
    # And what it is beyond that halfway, nothing at levels: a spline through these is the difference of both.
    halves = np.insert(np.zeros(len(places)), np.arange(1, len(places)), beyond)
    return float(way(time_s) + CubicSpline(np.linspace(0, times[-1], len(halves)), halves, bc_type="natural")(time_s))


def _wall(world: World, values: Values, how: str) -> World:
    """A wall far ahead, and nothing else: `through`, where depth is unknown, or `across` the view."""
    still = values["still"] > 0.5
    camera = start_from_camera(world, "range_aliasing with still") if still else np.eye(4)
    # Level, then lifted: a frame that looks where it is so far away. Its points from any three corners of the wall.
    looks = Rotation.from_euler("YX", [values["azimuth"], values["elevation"]])
    away = values["depth"] + world.time_s * values["speed"]
    slopes = np.array([[0, 0, 1], [1, 0, 1 - values["tilt_x"]], [0, 1, 1 - values["tilt_y"]]])
    corners = [looks.apply(away * np.array([x, y, z])) for x, y, z in slopes]
    corners = [camera[:3, :3].T @ (corner - camera[:3, 3]) for corner in corners]
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    rays = replace(world, depth_m=np.ones(world.depth_m.shape)).points
    ahead = rays @ normal / (corners[0] @ normal)
    cosine = rays @ normal / np.linalg.norm(normal) / np.linalg.norm(rays, axis=-1)
    there = ((how == "across") | ~(world.depth_m > 0)) & (ahead > 0) & (cosine > EDGE_ON)
    wall = replace(world, depth_m=np.where(there, 1 / np.where(there, ahead, 1), np.nan))
    return replace(wall, reflectance=np.full(cosine.shape, values[how]), cosine=cosine, gloss=1.0, behind=None)


def _thing(world: World, values: Values) -> World:
    """A board far off, and nothing else; it faces the place where the session began."""
    camera = start_from_camera(world, "range_aliasing with still") if values["still"] > 0.5 else np.eye(4)
    looks = Rotation.from_euler("YX", [values["azimuth"], values["elevation"]])
    away = values["depth"] + world.time_s * values["speed"]
    rays = replace(world, depth_m=np.ones(world.depth_m.shape)).points
    # Where rays from the camera, as the first would see them, come through z + tilt · (x, y) = away before it.
    begin, way = looks.inv().apply(camera[:3, 3]), looks.inv().apply((rays @ camera[:3, :3].T).reshape(-1, 3))
    slope = np.array([values["tilt_x"], values["tilt_y"], 1.0])
    depth = (away - begin @ slope) / (way @ slope)
    places = begin[:2] + depth[:, None] * way[:, :2]
    outside = np.abs(places) / (np.array([values["wide"], values["high"]]) * away) - 1
    cosine = way @ slope / np.linalg.norm(slope) / np.linalg.norm(way, axis=1)
    part = ((depth > 0) & (cosine > EDGE_ON)) / (1 + np.exp(np.clip(outside / RIM, -60, 60))).prod(axis=1)
    shape = world.depth_m.shape
    depth, cosine, part = (of.reshape(shape) for of in (np.where(depth > 0, depth, np.nan), cosine, part))
    part = part * (1 - values["hidden"] * (world.depth_m > 0))
    return replace(world, depth_m=depth, reflectance=values["distant"] * part, cosine=cosine, gloss=1.0, behind=None)

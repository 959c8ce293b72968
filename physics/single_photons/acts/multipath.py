"""`multipath`: photons meet a second surface before they come back."""

from dataclasses import dataclass

import numpy as np
from scipy.constants import speed_of_light

from physics.effect import Values
from physics.single_photons.by_patch import patch_light, patch_way
from physics.single_photons.by_plane import plane_light
from physics.single_photons.draw import delays, many
from physics.single_photons.facing import facets, solid_angles
from physics.single_photons.world import Photons, World

# Between so many points paths are drawn; where the image has more, in each frame between others, chosen at random.
MOST_POINTS = 3000
ROWS = 256


@dataclass(frozen=True, eq=False)
class Lit:
    """N points of surfaces that send photons back. pixel: (N,) flat index. point_m, normal: (N, 3). area_m2: (N,).

    sends: (N,) light sent back to a square metre at the sensor. albedo, solid_sr, cosine: (N,) reflectance, pixel's
    solid angle, and cosine of the ray's angle to the optical axis. weights: (P, N).
    """

    pixel: np.ndarray
    point_m: np.ndarray
    normal: np.ndarray
    area_m2: np.ndarray
    sends: np.ndarray
    albedo: np.ndarray
    solid_sr: np.ndarray
    cosine: np.ndarray
    weights: np.ndarray

    @property
    def range_m(self) -> np.ndarray:
        """(N,)."""
        return np.linalg.norm(self.point_m, axis=1)


def photons(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """More photons, of eight kinds."""
    for way in (_by_the_lens, _by_a_mirror, _by_walls_around, _in_a_cavity):
        photons = photons.and_also(way(world, values, rng))
    lit = _lit(world)
    ways = {"between": _between, "sensor": _by_the_sensors_face, "outside": _by_a_plane_outside, "patch": _by_a_patch}
    for share, way in ways.items():
        if values[share] > 0 and len(lit.pixel):
            photons = photons.and_also(way(lit, world, values, rng))
    return photons


def _between(lit: Lit, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Sensor, surface i, surface j, sensor.

    A source of one unit of light by steradian, seen through i's pixel, puts ΔΩ on i, less where it is aimed at what the
    zones see; i scatters ρ of it by Lambert's
    law, cosφ/π by steradian. j, turned by φ', is met by what goes into cosφ'/d² steradians of each square metre, and
    sends ρ of that back as any surface does. That i is no point shows near it: photons that leave a disc of area A on
    its axis are met at distance d not with 1/(πd²) but 1/(πd² + A).
    """
    every = len(lit.pixel)
    some = min(every, MOST_POINTS)
    firsts, seconds = (rng.choice(every, some, replace=False) for _ in range(2))
    stands_for = values["between"] * world.gain * (every / some) ** 2
    seen = lit.weights[:, seconds] * lit.albedo[seconds]
    looked = lit.weights.sum(axis=0)
    sent = (
        lit.albedo * lit.solid_sr * (1 - values["aimed"] + values["aimed"] * looked / world.weights.sum(axis=0).max())
    )
    pairs = [np.zeros((0, 2), int)]
    for at in range(0, some, ROWS):
        i = firsts[at : at + ROWS]
        way = lit.point_m[None, seconds] - lit.point_m[i, None]
        apart = np.linalg.norm(way, axis=-1)
        leaves = np.einsum("ijk,ik->ij", way, lit.normal[i]) / np.where(apart > 0, apart, 1)
        meets = -np.einsum("ijk,jk->ij", way, lit.normal[seconds]) / np.where(apart > 0, apart, 1)
        matt = np.clip(leaves, 0, None) * np.clip(meets, 0, None)
        # Facets of a rough surface face all ways: half is the mean of their cosines.
        facing = matt + values["rough"] * (np.where(apart > 0, 0.5 * 0.5, 0) - matt)
        met = facing / (np.pi * apart**2 + lit.area_m2[i, None])
        first, second = np.nonzero(met)
        mean = stands_for * sent[i][first] * met[first, second] * seen.sum(axis=0)[second]
        number = rng.poisson(mean)
        pairs.append(np.repeat(np.column_stack([i[first], second]), number, axis=0))
    first, second = np.concatenate(pairs).T
    # Whose photon it is: zones have shares of what the second pixel sends.
    shares = np.cumsum(seen, axis=0)
    zone = (rng.random(len(second)) * shares[-1, second] >= shares[:-1, second]).sum(axis=0)
    second = seconds[second]
    path = lit.range_m[first] + np.linalg.norm(lit.point_m[second] - lit.point_m[first], axis=1) + lit.range_m[second]
    return _photons(world, zone, lit.pixel[second], path, rng)


def _by_the_sensors_face(lit: Lit, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Sensor, surface i, the sensor's face, surface j, sensor.

    A matt surface that sends S to a square metre at the sensor has the radiance S/π by steradian that the pixel fills.
    What the face scatters to j, matt as well, leaves it by the cosine over π, and returns from j as the laser's does.
    """
    caught = lit.sends / np.pi * lit.solid_sr * lit.cosine
    lamp = values["sensor"] * caught.sum() * lit.cosine / np.pi
    zone, second = many((world.gain * lit.weights * lit.sends * lamp)[:, None], rng)
    first = rng.choice(len(caught), len(second), p=caught / caught.sum())
    path = 2 * (lit.range_m[first] + lit.range_m[second])
    return _photons(world, zone, lit.pixel[second], path, rng)


def _by_the_lens(world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Sensor, surface, lens, the same surface, sensor: lit again by so much of what it sent to a square metre."""
    sends = _sends(world, world.range_m**2)
    zone, pixel = many(world.gain * values["retro"] * world.weights * sends * sends, rng)
    return _photons(world, zone, pixel, 4 * world.range_m.ravel()[pixel] + 2 * values["face"], rng)


def _by_a_mirror(world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Sensor, surface, the sensor's face, the same surface, sensor: a part that falls with a power of range."""
    sends = _sends(world, world.range_m ** (2 + values["spreading"]))
    zone, pixel = many(world.gain * values["mirrored"] * world.weights * sends, rng)
    return _photons(world, zone, pixel, 4 * world.range_m.ravel()[pixel] + 2 * values["face"], rng)


def _by_walls_around(world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Sensor, a wall where it mirrors, surface, sensor: as from a source twice as far aside as the wall."""
    far = np.sqrt(world.range_m**2 + (2 * values["around_distance"]) ** 2)
    zone, pixel = many(world.gain * values["around"] * world.weights * _sends(world, far**2), rng)
    return _photons(world, zone, pixel, (far + world.range_m).ravel()[pixel], rng)


def _in_a_cavity(world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Sensor, surface, and round a cavity as large as it is far: a way longer by a part that is gamma-distributed."""
    zone, pixel = many(world.gain * values["cavity"] * world.weights * _sends(world, world.range_m**2), rng)
    spread = values["cavity_breadth"] ** 2
    longer = rng.gamma(1 / spread, values["cavity_late"] * spread, len(zone))
    return _photons(world, zone, pixel, 2 * world.range_m.ravel()[pixel] * (1 + longer), rng)


def _sends(world: World, dimmer: np.ndarray) -> np.ndarray:
    """What each pixel's surface sends back of light that is dimmed so much; nothing where there is no surface."""
    facing = np.clip(world.cosine, 0, None)
    return np.nan_to_num(world.reflectance * world.gloss * facing / np.where(world.range_m > 0, dimmer, np.nan))


def _by_a_plane_outside(lit: Lit, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Sensor, a point of the plane where it mirrors, surface, sensor."""
    light, far = plane_light(lit.point_m, lit.normal, lit.albedo, lit.sends, world, values)
    zone, target = many((world.gain * lit.weights * light)[:, None], rng)
    return _photons(world, zone, lit.pixel[target], (far + lit.range_m)[target], rng)


def _by_a_patch(lit: Lit, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Sensor, the patch, surface, sensor."""
    light = patch_light(lit.point_m, lit.normal, lit.albedo, lit.sends, world, values)
    zone, target = many((world.gain * lit.weights * light)[:, None], rng)
    far = patch_way(lit.point_m[target], world, values, rng)
    return _photons(world, zone, lit.pixel[target], far + lit.range_m[target], rng)


def _photons(
    world: World, zone: np.ndarray, pixel: np.ndarray, path_m: np.ndarray, rng: np.random.Generator
) -> Photons:
    """Photons that went all of a path."""
    time = world.time_zero_s[zone] + path_m / speed_of_light + delays(world, len(zone), rng)
    detour = path_m - 2 * world.range_m.ravel()[pixel]
    return Photons(zone.astype(np.int32), time, pixel.astype(np.int32), np.zeros(len(zone), np.int32), detour)


def _lit(world: World) -> Lit:
    """Points of a frame whose light comes back directly and whose slope is known."""
    area, points = facets(world).reshape(-1, 3), world.points.reshape(-1, 3)
    square = np.where(world.depth_m > 0, world.range_m, np.inf).ravel() ** 2
    sends = (world.reflectance * world.gloss * np.clip(world.cosine, 0, None)).ravel() / square
    pixel = np.flatnonzero(np.isfinite(area).all(axis=1) & (np.nan_to_num(sends) > 0))
    size = np.linalg.norm(area[pixel], axis=1)
    return Lit(
        pixel=pixel,
        point_m=points[pixel],
        normal=area[pixel] / size[:, None],
        area_m2=size,
        sends=sends[pixel],
        albedo=world.reflectance.ravel()[pixel],
        solid_sr=solid_angles(world).ravel()[pixel],
        cosine=points[pixel, 2] / np.linalg.norm(points[pixel], axis=1),
        weights=world.weights.reshape(world.zones, -1)[:, pixel],
    )

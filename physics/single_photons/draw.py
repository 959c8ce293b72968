"""Photons are drawn: what surfaces send back, pulses from elsewhere, background; and put into bins."""

import numpy as np
from scipy.constants import speed_of_light

from physics.single_photons.world import NO_PIXEL, Photons, World
from recordings.refusal import Refusal

# About 60 bytes each while they are worked on: more than this in one frame is a slip, not a sensor.
MOST_PHOTONS = 100_000_000


def by_zone(world: World, value: float | np.ndarray) -> np.ndarray:
    """(P,) a parameter's value for each zone."""
    return np.broadcast_to(np.asarray(value, float), (world.zones,))


def delays(world: World, count: int, rng: np.random.Generator) -> np.ndarray:
    """(count,) seconds between nominal arrival and registration, drawn from the pulse, evenly within its step."""
    step = world.pulse_time_s[1] - world.pulse_time_s[0]
    heaped = np.append(0.0, np.cumsum(world.pulse))
    edges = np.append(world.pulse_time_s - step / 2, world.pulse_time_s[-1] + step / 2)
    return np.interp(rng.random(count) * heaped[-1], heaped, edges)


def returned(world: World, rng: np.random.Generator) -> Photons:
    """Photons that surfaces send back once: Poisson by zone and pixel, each at its own time."""
    ranges = world.range_m
    per_area = world.reflectance * world.gloss * np.maximum(world.cosine, 0)
    seen = np.isfinite(per_area) & (ranges > 0)
    per_area = np.where(seen, per_area, 0) / np.where(seen, ranges, 1) ** 2
    zone, pixel = many(world.gain * world.weights * per_area, rng)
    travel = 2 * np.where(seen, ranges, 0).ravel() / speed_of_light
    time = travel[pixel] + world.time_zero_s[zone] + delays(world, len(zone), rng)
    if world.behind is None:
        return Photons(zone, time, pixel, np.zeros(len(zone), np.int32))
    part, metres = (field.ravel()[pixel] for field in world.behind)
    detour = 2 * np.where(rng.random(len(pixel)) < part, metres, 0.0)
    return Photons(zone, time + detour / speed_of_light, pixel, np.zeros(len(zone), np.int32), detour)


def pulse_from_elsewhere(
    world: World, counts: float | np.ndarray, arrival_s: float | np.ndarray, rng: np.random.Generator
) -> Photons:
    """A pulse that comes from no pixel: Poisson `counts` by zone, nominally at `arrival_s`; (P,) or one for all."""
    number = rng.poisson(by_zone(world, counts))
    _bearable(int(number.sum()))
    zone = np.repeat(np.arange(world.zones, dtype=np.int32), number)
    return loose(zone, by_zone(world, arrival_s)[zone] + delays(world, len(zone), rng))


def background(world: World, rng: np.random.Generator) -> Photons:
    """What no laser sent: even in time over the window."""
    number = rng.poisson(world.background * world.bins)
    _bearable(int(number.sum()))
    zone = np.repeat(np.arange(world.zones, dtype=np.int32), number)
    return loose(zone, rng.random(len(zone)) * (world.bins * world.bin_width_s))


def loose(zone: np.ndarray, time_s: np.ndarray) -> Photons:
    """Photons of these zones and times (N,) that come from no pixel."""
    return Photons(zone, time_s, np.full(len(zone), NO_PIXEL, np.int32), np.zeros(len(zone), np.int32))


def way_m(photons: Photons, world: World) -> np.ndarray:
    """(N,) metres from the sensor and back; for photons that come from no pixel it says nothing."""
    straight = 2 * world.range_m.ravel()[photons.pixel]
    return straight if photons.detour_m is None else straight + photons.detour_m


def in_window(photons: Photons, world: World) -> np.ndarray:
    """(N,) whether each is registered in one of the bins."""
    return (photons.time_s >= 0) & (photons.time_s < world.bins * world.bin_width_s)


def counts_of(photons: Photons, world: World) -> np.ndarray:
    """(P, T) int64 photons by zone and bin; what falls outside the window is lost."""
    place = np.floor(photons.time_s / world.bin_width_s)
    inside = (place >= 0) & (place < world.bins)
    cell = photons.zone[inside] * np.int64(world.bins) + place[inside].astype(np.int64)
    return np.bincount(cell, minlength=world.zones * world.bins).reshape(world.zones, world.bins)


def many(mean: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Zone and flat pixel, (N,) int32 each, of Poisson photons whose mean numbers are (P, H, W)."""
    _bearable(float(mean.sum()))
    flat = mean.reshape(len(mean), -1)
    zone, pixel = np.nonzero(flat)
    number = rng.poisson(flat[zone, pixel])
    return np.repeat(zone.astype(np.int32), number), np.repeat(pixel.astype(np.int32), number)


def _bearable(count: float) -> None:
    """Refuse more photons in a frame than memory bears."""
    if not count <= MOST_PHOTONS:
        raise Refusal(f"one frame has {count:.3g} photons, expected {MOST_PHOTONS:.3g} at most: lower the gain")

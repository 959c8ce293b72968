"""`gain_drift`: more photons come, or fewer, the later it is."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.draw import by_zone
from physics.single_photons.walking import height_by_now
from physics.single_photons.world import Photons, World


def world(world: World, values: Values, rng: np.random.Generator) -> World:
    """As many photons for all as the zone counts that has become most sensitive; the background in a power of it."""
    times = _times(world, values)
    most, dark = float(times.max()), world.background * times ** values["background"]
    return replace(world, gain=world.gain * most, boost=world.boost * most, background=dark)


def photons(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Of these the other zones lose their part; of the background they have had it."""
    times = _times(world, values)
    if np.ptp(times) == 0:
        return photons
    return photons.only(rng.random(len(photons)) < (times / times.max())[photons.zone])


def _times(world: World, values: Values) -> np.ndarray:
    """(P,) factor of each zone by now."""
    now = world.time_s
    settled = by_zone(world, values["warmup"]) * np.exp(-now / values["tau"])
    right = _since_start(world, values | {"jump": 0.0}, values["zero_at"])
    return np.exp(_since_start(world, values, now) - right + settled)


def _since_start(world: World, values: Values, time_s: float) -> np.ndarray:
    """(P,) logarithm of what it has come to by a time, but for warming up."""
    steady = by_zone(world, values["rate"]) * time_s + values["curve"] * time_s**2
    return steady + height_by_now(values, time_s)

"""`bin_width_error`: photons are sorted into bins that are wider or narrower than is thought."""

from dataclasses import replace

import numpy as np
from scipy.constants import speed_of_light

from physics.effect import Values
from physics.single_photons.draw import by_zone
from physics.single_photons.world import Photons, World


def world(world: World, values: Values, rng: np.random.Generator) -> World:
    """Photons fly and wait as ever. The clock's ticks are longer, and time zero is a number of them, or in part not.

    Or it is such that a target at some range is in the bin it would be in. A pulse may be a number of them, too.
    """
    ticks = world.time_zero_s / world.bin_width_s * (1 - values["zero_in_seconds"])
    kept = world.time_zero_s * values["zero_in_seconds"]
    settled = 1 - np.exp(-world.time_s / values["tau"])
    width = world.bin_width_s * (1 + values["error"] + values["warmup"] * settled)
    later = (width / world.bin_width_s - 1) * _flight_s(values)
    pulse_s = world.pulse_time_s * (1 + values["error"] * values["pulse_in_bins"])
    return replace(world, bin_width_s=width, time_zero_s=ticks * width + kept + later, pulse_time_s=pulse_s)


def photons(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """In zones whose ticks are longer still, fewer of them since time zero: as if there had been less time."""
    width = 1 + values["error"] + values["warmup"] * (1 - np.exp(-world.time_s / values["tau"]))
    ticks, flight = 1 - values["zero_in_seconds"], _flight_s(values)
    zero = (world.time_zero_s - (width - 1) * flight) / (1 + (width - 1) * ticks)
    about = by_zone(world, width * (zero * ticks + flight))[photons.zone]
    part = width / (width + by_zone(world, values["apart"])[photons.zone])
    return replace(photons, time_s=about + part * (photons.time_s - about))


def _flight_s(values: Values) -> float:
    """There and back to the target that stays."""
    return 2 * values["still_at"] / speed_of_light

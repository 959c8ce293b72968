"""`impulse_width`: photons scatter more widely about the mean time of the pulse."""

from dataclasses import replace

import numpy as np
from scipy.constants import speed_of_light

from physics.effect import Values
from physics.single_photons.draw import by_zone, way_m
from physics.single_photons.world import NO_PIXEL, Photons, World


def world(world: World, values: Values, rng: np.random.Generator) -> World:
    """The same steps of the pulse, each as much farther from the mean, or from 0, and as much wider."""
    if np.ndim(values["broader"]):
        return world
    mean = values["centred"] * np.average(world.pulse_time_s, weights=world.pulse)
    return replace(world, pulse_time_s=mean + (1 + values["broader"]) * (world.pulse_time_s - mean))


def photons(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Each photon that a laser sent has a delay of its own beside that of the pulse, or that many times as long."""
    normal, alike = rng.standard_normal(len(photons)), np.sqrt(3) * rng.uniform(-1, 1, len(photons))
    late = np.sqrt(1 - values["even"]) * normal + np.sqrt(values["even"]) * alike
    time_s = photons.time_s + by_zone(world, values["jitter"])[photons.zone] * late
    if np.ndim(values["broader"]):
        mean = values["centred"] * np.average(world.pulse_time_s, weights=world.pulse)
        nominal = world.time_zero_s[photons.zone] + way_m(photons, world) / speed_of_light
        more = by_zone(world, values["broader"])[photons.zone] * (photons.time_s - nominal - mean)
        time_s = time_s + np.where(photons.pixel == NO_PIXEL, 0.0, more)
    return replace(photons, time_s=time_s)

"""`impulse_width`: photons scatter more widely about the mean time of the pulse."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.draw import by_zone
from physics.single_photons.world import Photons, World


def world(world: World, values: Values, rng: np.random.Generator) -> World:
    """The same steps of the pulse, each as much farther from the mean, or from 0, and as much wider."""
    mean = values["centred"] * np.average(world.pulse_time_s, weights=world.pulse)
    return replace(world, pulse_time_s=mean + (1 + values["broader"]) * (world.pulse_time_s - mean))


def photons(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Each photon that a laser sent has a delay of its own beside that of the pulse."""
    normal, alike = rng.standard_normal(len(photons)), np.sqrt(3) * rng.uniform(-1, 1, len(photons))
    late = np.sqrt(1 - values["even"]) * normal + np.sqrt(values["even"]) * alike
    return replace(photons, time_s=photons.time_s + by_zone(world, values["jitter"])[photons.zone] * late)

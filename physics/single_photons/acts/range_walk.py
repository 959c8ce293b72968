"""`range_walk`: photons that come with many others are early."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.draw import by_zone, in_window
from physics.single_photons.world import Photons, World


def photons(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Each by how many its zone received in this frame."""
    received = np.bincount(photons.zone[in_window(photons, world)], minlength=world.zones)
    early_s = _early(world, values, received) - _early(world, values, values["reference"])
    return replace(photons, time_s=photons.time_s - early_s[photons.zone])


def _early(world: World, values: Values, received: np.ndarray | float) -> np.ndarray:
    """(P,) seconds by which light is early in zones that received so many photons."""
    walk = by_zone(world, values["walk"]) / (1 + values["level"] / np.maximum(received, 1e-9))
    return walk + by_zone(world, values["logarithmic"]) * np.log((values["level"] + received) / values["level"])

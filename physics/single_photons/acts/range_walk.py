"""`range_walk`: photons that come with many others are early."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.draw import by_zone, in_window
from physics.single_photons.world import Photons, World


def photons(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Each by how many its zone received in this frame."""
    received = np.bincount(photons.zone[in_window(photons, world)], minlength=world.zones)
    early_s = by_zone(world, values["walk"]) / (1 + values["level"] / np.maximum(received, 1))
    early_s = early_s + by_zone(world, values["logarithmic"]) * np.log((values["level"] + received) / values["level"])
    return replace(photons, time_s=photons.time_s - early_s[photons.zone])

"""`range_walk`: photons that come with many others are early."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.draw import by_zone, counts_of
from physics.single_photons.world import Photons, World


def photons(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Each by how many its zone received in this frame, in all or in its fullest bin."""
    counts = counts_of(photons, world)
    received = counts.sum(axis=1) + values["fullest"] * (counts.max(axis=1) - counts.sum(axis=1))
    early_s = _early(world, values, received) - _early(world, values, values["reference"])
    return replace(photons, time_s=photons.time_s - early_s[photons.zone])


def _early(world: World, values: Values, received: np.ndarray | float) -> np.ndarray:
    """(P,) seconds by which light is early in zones that received so many photons."""
    walk = by_zone(world, values["walk"]) / (1 + values["level"] / np.maximum(received, 1e-9))
    return walk + by_zone(world, values["logarithmic"]) * np.log((values["level"] + received) / values["level"])

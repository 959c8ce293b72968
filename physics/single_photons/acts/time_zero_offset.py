"""`time_zero_offset`: photons of a zone are late."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.draw import by_zone
from physics.single_photons.world import Photons, World


def photons(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Each by its zone's delay."""
    return replace(photons, time_s=photons.time_s + by_zone(world, values["delay"])[photons.zone])

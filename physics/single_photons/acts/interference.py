"""`interference`: photons of another emitter."""

import numpy as np

from physics.effect import Values
from physics.single_photons.draw import by_zone, pulse_from_elsewhere
from physics.single_photons.world import Photons, World


def photons(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Its pulse, where it has wandered by the time of this frame."""
    arrival_s = values["arrival"] + values["drift"] * world.time_s
    return photons.and_also(pulse_from_elsewhere(world, by_zone(world, values["counts"]) * world.boost, arrival_s, rng))

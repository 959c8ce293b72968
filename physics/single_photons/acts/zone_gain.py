"""`zone_gain`: zones let more or less of the laser's photons through."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.draw import by_zone
from physics.single_photons.world import Photons, World


def world(world: World, values: Values, rng: np.random.Generator) -> World:
    """As many photons for all as the most sensitive zone counts: none is there twice."""
    most = _most(values)
    return replace(world, gain=world.gain * most, boost=world.boost * most)


def photons(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Of these the others lose their part."""
    passed = by_zone(world, values["factor"]) / _most(values)
    return photons.only(rng.random(len(photons)) < passed[photons.zone])


def _most(values: Values) -> float:
    """The largest factor, 1 at least."""
    return max(1.0, float(np.max(values["factor"])))

"""`ambient_pedestal`: more background."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.draw import by_zone
from physics.single_photons.world import World


def world(world: World, values: Values, rng: np.random.Generator) -> World:
    """As many counts more in each bin."""
    return replace(world, background=world.background + by_zone(world, values["level"]))

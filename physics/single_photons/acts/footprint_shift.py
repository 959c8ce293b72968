"""`footprint_shift`: zones look beside where their maps say."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.looking import looking, looking_so
from physics.single_photons.world import World


def world(world: World, values: Values, rng: np.random.Generator) -> World:
    """A zone that looks farther right sees of each pixel what it would have seen farther left."""
    how = looking(world)
    slipped = world.time_s * np.array([values["slip_x"], values["slip_y"]], float)
    shift = (np.array([values["x"], values["y"]], float) + slipped)[:, None, None]
    return looking_so(world, replace(how, ways=(*how.ways, lambda _: -shift)))

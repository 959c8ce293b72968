"""`footprint_shift`: zones look beside where their maps say."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.draw import by_zone
from physics.single_photons.looking import looking, looking_so
from physics.single_photons.world import World


def world(world: World, values: Values, rng: np.random.Generator) -> World:
    """A zone that looks farther right sees of each pixel what it would have seen farther left."""
    how = looking(world)
    slipped = world.time_s * np.array([values["slip_x"], values["slip_y"]], float)
    shift = np.stack([by_zone(world, values["x"]), by_zone(world, values["y"])]) + slipped[:, None]
    # One shift for all is one way for all.
    alike = np.ndim(values["x"]) == 0 and np.ndim(values["y"]) == 0
    shift = shift[:, :1, None] if alike else shift[..., None, None]
    return looking_so(world, replace(how, ways=(*how.ways, lambda _: -shift)))

"""`footprint_shift`: zones look beside where their maps say."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.draw import by_zone
from physics.single_photons.looking import looking, looking_so
from physics.single_photons.sight import pixel_places
from physics.single_photons.world import World


def world(world: World, values: Values, rng: np.random.Generator) -> World:
    """A zone that looks farther right sees of each pixel what it would have seen farther left."""
    how = looking(world)
    slipped = complex(values["slip_x"], values["slip_y"]) * world.time_s
    shift = by_zone(world, values["x"]) + 1j * by_zone(world, values["y"]) + slipped
    # One shift for all is one way for all.
    alike = np.ndim(values["x"]) == 0 and np.ndim(values["y"]) == 0
    shift = shift[0] if alike else shift[:, None, None]
    # Right and down are 1 and i about the middle of the image: maps are turned by a product.
    right, down = (
        place - (size - 1) / 2
        for place, size in zip(pixel_places(how.taken, world.depth_m.shape), how.taken.image_size, strict=True)
    )
    here = right + 1j * down
    away = (here - shift) / ((1 + values["zoom"]) * np.exp(1j * values["turn"])) - here
    away = np.stack([away.real, away.imag])
    how = replace(how, by_pixels=max(how.by_pixels, values["by_pixels"]))
    return looking_so(world, replace(how, ways=(*how.ways, lambda _: away)))

"""`non_lambertian`: surfaces send photons back along the ray by which they came."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.surfaces import surface_numbers
from physics.single_photons.world import World


def world(world: World, values: Values, rng: np.random.Generator) -> World:
    """Gloss is light over matt light: powers of the cosine, that of a surface and that of its lobe, over the cosine.

    Blinn's lobe is about the direction halfway between light and eye (SIGGRAPH 1977). Both are the sensor here, so that
    its angle to the normal is that of incidence.
    """
    facing = np.nan_to_num(world.cosine) > 0
    angle = np.arccos(np.clip(np.where(facing, world.cosine, 1), 0, 1))
    matt = np.maximum(np.cos(angle), np.finfo(float).tiny)
    sent = np.cos(angle) ** (1 + values["power"]) + values["lobe"] * np.cos(angle) ** values["exponent"] / (
        np.maximum(2 * world.reflectance, 0.04) ** (1 - values["pigment"])
    )
    if values["gloss"] > 0:
        own = values["gloss"] * np.cos(angle) ** values["gloss_exponent"]
        sent += own * (surface_numbers(world) == round(values["surface"]))
    glossier = np.clip(sent, 0, None) / matt
    return replace(world, gloss=world.gloss * np.where(facing, glossier, 1))

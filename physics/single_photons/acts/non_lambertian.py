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
    sent = np.cos(angle) ** (1 + values["power"]) + values["lobe"] * _facets(
        angle, values["exponent"], values["tail"]
    ) / (np.maximum(2 * world.reflectance, 0.04) ** (1 - values["pigment"]))
    if values["gloss"] > 0:
        glossy = surface_numbers(world, values) == round(values["surface"])
        sent[glossy] *= values["matt"]
        sent += glossy * values["gloss"] * _facets(angle, values["gloss_exponent"], values["tail"])
    each = np.array([0, *(values[f"gloss_{k}"] for k in range(1, 9)), 0])
    if each.any():
        part = np.minimum(surface_numbers(world, {"told_by": 2}), 9)
        sent += each[part] * _facets(angle, values["gloss_exponent"], values["tail"])
    glossier = np.clip(sent, 0, None) / matt
    return replace(world, gloss=world.gloss * np.where(facing, glossier, 1))


def _facets(angle: np.ndarray, exponent: float, tail: float) -> np.ndarray:
    """Facets that face the sensor, over those that lie in the surface: slopes by Student's t of exponent/tail."""
    return (1 + tail * np.tan(angle) ** 2) ** (-exponent / tail / 2)

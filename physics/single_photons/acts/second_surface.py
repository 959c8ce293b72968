"""`second_surface`: photons that pass the first surface come back from the one behind it, or from a sheet before it."""

from dataclasses import replace

import numpy as np
from scipy.constants import speed_of_light

from physics.effect import Values
from physics.single_photons.draw import returned, way_m
from physics.single_photons.world import NO_PIXEL, Photons, World

# A sheet fades as it comes nearer than this, or than half the range of what is behind it; metres.
FADES_M = 0.1


def photons(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Some of those from surfaces pass; the larger sphere over which they return thins them, and they are late."""
    spacing = values["spacing"]
    passes = (rng.random(len(photons)) < values["passed"]) & (photons.pixel != NO_PIXEL)
    if spacing < 0:
        return photons.only(~passes).and_also(_before(world, values, rng))
    ranges = way_m(photons, world) / 2
    meets = rng.random(len(photons)) * (ranges + spacing) ** 2 < ranges**2
    further = np.where(passes, 2 * spacing, 0.0)
    late = replace(
        photons,
        time_s=photons.time_s + further / speed_of_light,
        detour_m=further if photons.detour_m is None else photons.detour_m + further,
    )
    return late.only(~passes | meets)


def _before(world: World, values: Values, rng: np.random.Generator) -> Photons:
    """What a sheet before the surface sends back straight: of other ways than the direct one it has no part."""
    far = np.where(world.range_m > 0, world.range_m, np.nan)
    near = far + values["spacing"]
    fades = np.clip(near / np.minimum(FADES_M, far / 2), 0, 1)
    # Light goes by 1/r² of the range at which it is drawn; a sheet that fades is no brighter than where it begins to.
    floor = np.maximum(near, np.minimum(FADES_M, far / 2))
    seen = near > 0
    dimmer = np.where(seen, fades * (near / floor) ** 2, 0)
    depth = world.depth_m * np.where(seen, near, np.nan) / far
    return returned(replace(world, depth_m=depth, gloss=world.gloss * values["passed"] * dimmer), rng)

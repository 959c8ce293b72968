"""`range_falloff`: photons of near surfaces miss the detector, or those of far ones do."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.draw import by_zone, way_m
from physics.single_photons.world import NO_PIXEL, Photons, World


def world(world: World, values: Values, rng: np.random.Generator) -> World:
    """As many photons more as the brightest place has, for `photons` to take from."""
    return replace(world, gain=world.gain * _most(world, values))


def photons(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Out of focus a spot is as large as detector and blur together: those that fall on the detector are kept."""
    ranges = way_m(photons, world) / 2
    # How far the spot's edge is off where its rays cross at the focus; at infinity they are parallel.
    blur = by_zone(world, values["overlap_range"])[photons.zone] * np.abs(1 - values["focus"] * ranges)
    near, far = blur ** values["steepness"], ranges ** values["steepness"]
    # Each by one of three laws: out of focus; a Gaussian beam's, inside so many radii; over a field's edge or not yet.
    law = np.floor(values["sudden"] + rng.random(len(photons)))
    inside, over = rng.exponential(size=len(photons)) * near < far, rng.random(len(photons)) * near < far
    caught = np.select([law == 0, law == 1], [rng.random(len(photons)) * (far + near) < far, inside], over)
    faster = by_zone(world, values["exponent"])[photons.zone]
    caught &= rng.random(len(photons)) * _most(world, values) < np.maximum(ranges, 1e-9) ** -faster
    return photons.only(caught | (photons.pixel == NO_PIXEL))


def _most(world: World, values: Values) -> float:
    """The largest factor that the exponent gives at any range there is."""
    ranges = world.range_m[np.isfinite(world.range_m) & (world.range_m > 0)]
    if not len(ranges):
        return 1.0
    ends = np.array([ranges.min(), 4 * ranges.max()])
    return float(max(1.0, (ends[:, None] ** -by_zone(world, values["exponent"])).max()))

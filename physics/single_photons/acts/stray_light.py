"""`stray_light`: photons scattered in the lens fall on all zones."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.draw import by_zone, returned
from physics.single_photons.world import Photons, World


def photons(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Beside each photon another falls on each zone with the probability of that zone, and is timed by its clock, or
    keeps its time by chance.

    Pairs share their pulse's delay: counts of any one bin are Poisson all the same, counts of two bins hang together
    as little as the share is.
    """
    photons = photons.and_also(_glare(world, values, rng))
    share, everything = by_zone(world, values["share"]), photons
    for zone in range(world.zones):
        stray = photons.only(rng.random(len(photons)) < share[zone])
        later = world.time_zero_s[zone] - world.time_zero_s[stray.zone]
        time = stray.time_s + np.where(rng.random(len(stray)) < values["clocks"], 0.0, later)
        everything = everything.and_also(replace(stray, zone=np.full_like(stray.zone, zone), time_s=time))
    return everything


def _glare(world: World, values: Values, rng: np.random.Generator) -> Photons:
    """What surfaces all over the field send to each zone, wherever it looks."""
    glare = by_zone(world, values["glare"])
    x, y, _ = np.moveaxis(replace(world, depth_m=np.ones(world.depth_m.shape)).points, -1, 0)
    bell = np.exp(-0.5 * (x / values["glare_x"]) ** 2) * np.exp(-0.5 * (y / values["glare_y"]) ** 2)
    return returned(replace(world, weights=glare[:, None, None] * bell), rng)

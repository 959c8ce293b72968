"""`time_zero_drift`: photons are the later the later it is."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.draw import by_zone
from physics.single_photons.walking import height_by_now
from physics.single_photons.world import Photons, World


def photons(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Each by what has come together since time zero was right, in its zone."""
    rate = by_zone(world, values["rate"])[photons.zone]
    late = [
        rate * t
        + values["curve"] * t**2
        + values["warmup"] * (1 - np.exp(-t / values["tau"]))
        + height_by_now(values, t)
        for t in (world.time_s, values["zero_at"])
    ]
    return replace(photons, time_s=photons.time_s + late[0] - late[1])

"""`time_zero_drift`: photons are the later the later it is."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.world import Photons, World


def photons(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Each by what there was in the first frame and has come together since."""
    late = (
        values["at_start"]
        + values["rate"] * world.time_s
        + values["warmup"] * (1 - np.exp(-world.time_s / values["tau"]))
    )
    late += values["curve"] * world.time_s**2
    return replace(photons, time_s=photons.time_s + late)

"""`impulse_tail`: some photons wait."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.world import Photons, World


def photons(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Some photons' carriers diffuse before they avalanche, each as long as it takes."""
    waits = rng.random(len(photons)) < values["share"]
    time = photons.time_s.copy()
    time[waits] += rng.exponential(values["tau"], int(waits.sum()))
    return replace(photons, time_s=time)

"""`impulse_tail`: some photons are sent late, some wait."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.draw import by_zone
from physics.single_photons.world import Photons, World


def photons(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Some are sent until the laser stops; some photons' carriers diffuse before they avalanche."""
    time = photons.time_s.copy()
    lingers = rng.random(len(photons)) < values["lingering"]
    time[lingers] += rng.uniform(0, values["duration"], int(lingers.sum()))
    waits = rng.random(len(photons)) < by_zone(world, values["share"])[photons.zone]
    time[waits] += rng.exponential(values["tau"], int(waits.sum()))
    return replace(photons, time_s=time)

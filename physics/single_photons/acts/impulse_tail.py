"""`impulse_tail`: some photons are sent late, some wait."""

from dataclasses import replace

import numpy as np
from scipy.stats import genpareto

from physics.effect import Values
from physics.single_photons.draw import by_zone
from physics.single_photons.world import Photons, World


def photons(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Some are sent until the laser stops; some photons' carriers diffuse before they avalanche."""
    time = photons.time_s.copy()
    lingers = rng.random(len(photons)) < values["lingering"]
    time[lingers] += rng.uniform(0, values["duration"], int(lingers.sum()))
    waits = rng.random(len(photons)) < by_zone(world, values["share"])[photons.zone]
    longer = genpareto(values["heavy"], scale=values["tau"])
    late_s = time.copy()
    late_s[waits] += longer.rvs(int(waits.sum()), random_state=rng)
    stay = ~waits | (rng.random(len(photons)) < values["added"])
    late = replace(photons, time_s=late_s).only(waits)
    return replace(photons, time_s=time).only(stay).and_also(late)

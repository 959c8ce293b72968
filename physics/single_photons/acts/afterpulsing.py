"""`afterpulsing`: an event traps carriers that set off another."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.draw import by_zone, in_window
from physics.single_photons.world import NO_PIXEL, Photons, World


def detected(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Some are followed by one more in the same channel and shot, after the rest of their bin, hold-off and a while.

    Traps of two kinds hold carriers for different times. All that comes from no pixel is taken for background.
    """
    found = photons
    ambient = (photons.pixel == NO_PIXEL) & (rng.random(len(photons)) >= values["ambient"])
    for probability, times in (("probability", 1.0), ("slower", values["times"])):
        trapped = (
            in_window(photons, world)
            & ~ambient
            & (rng.random(len(photons)) < by_zone(world, values[probability])[photons.zone])
        )
        events = photons.only(trapped)
        alive_s = (np.floor(events.time_s / world.bin_width_s) + 1) * world.bin_width_s
        # A trap of a depth by chance is an exponential at a rate by chance: gamma's mixture is Pareto's law.
        depth = rng.gamma(1 / values["heavy"], values["heavy"], len(events)) if values["heavy"] else 1.0
        released_s = (
            alive_s
            + max(values["dead"], -world.bin_width_s)
            + rng.exponential(times * values["tau"], len(events)) / depth
        )
        found = found.and_also(replace(events, time_s=released_s, pixel=np.full_like(events.pixel, NO_PIXEL)))
    return found

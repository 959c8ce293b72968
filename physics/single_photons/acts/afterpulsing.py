"""`afterpulsing`: an event traps carriers that set off another."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.draw import by_zone, in_window, loose
from physics.single_photons.world import NO_PIXEL, Photons, World

# Of carriers none to speak of are held for so many times as long as most.
HELD = 40.0


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
        tau_s = times * values["tau"]
        earlier = _earlier(world, values["earlier"] * by_zone(world, values[probability]), tau_s, rng)
        events = photons.only(trapped).and_also(earlier)
        alive_s = (np.floor(events.time_s / world.bin_width_s) + 1) * world.bin_width_s
        # A trap of a depth by chance is an exponential at a rate by chance: gamma's mixture is Pareto's law.
        depth = rng.gamma(1 / values["heavy"], values["heavy"], len(events)) if values["heavy"] else 1.0
        released_s = alive_s + max(values["dead"], -world.bin_width_s) + rng.exponential(tau_s, len(events)) / depth
        found = found.and_also(replace(events, time_s=released_s, pixel=np.full_like(events.pixel, NO_PIXEL)))
    if not values["deep"]:
        return found
    # Carriers of as many cycles before are released in this one, whenever.
    deep = photons.only(in_window(photons, world) & ~ambient & (rng.random(len(photons)) < values["deep"]))
    return found.and_also(loose(deep.zone, rng.random(len(deep)) * world.bins * world.bin_width_s))


def _earlier(world: World, trapped: np.ndarray, tau_s: float, rng: np.random.Generator) -> Photons:
    """Background before the window, as long as any of it is still held, of which (P,) are trapped."""
    long = HELD * tau_s / world.bin_width_s
    number = rng.poisson(trapped * world.background * long)
    zone = np.repeat(np.arange(world.zones, dtype=np.int32), number)
    return loose(zone, -rng.random(len(zone)) * long * world.bin_width_s)

"""`interference`: photons of another emitter."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.draw import by_zone, pulse_from_elsewhere
from physics.single_photons.world import Photons, World


def photons(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Its pulse, where it has wandered by the time of this frame; and one that is anywhere, if it is there at all."""
    wandered_s = values["arrival"] + values["drift"] * world.time_s
    window_s = world.bins * world.bin_width_s
    anywhere_s = rng.random() * window_s
    there = rng.random() < values["present"]
    # All that fall into the window or a window beside it: no pulse is longer.
    ends = ((side * window_s - wandered_s) / values["period"] for side in (-1, 2))
    first, last = (int(np.floor(end)) for end in ends)
    pulses = [(values["counts"], wandered_s + turn * values["period"]) for turn in range(first, last + 2)]
    for counts, arrival_s in (*pulses, (np.multiply(values["roaming"], there), anywhere_s)):
        more = pulse_from_elsewhere(world, by_zone(world, counts) * world.boost, arrival_s, rng)
        late = values["longer"] * rng.standard_normal(len(more))
        photons = photons.and_also(replace(more, time_s=more.time_s + late))
    return photons

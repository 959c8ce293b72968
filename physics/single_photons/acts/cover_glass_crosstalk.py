"""`cover_glass_crosstalk`: photons that only ever see the inside of the package."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.draw import by_zone, pulse_from_elsewhere
from physics.single_photons.world import Photons, World
from recordings.refusal import Refusal


def photons(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Each shot, or each frame, sends so many to each zone, with its own delay after time zero."""
    share, counts = (by_zone(world, values[name]) for name in ("share", "counts"))
    if share.any():
        if world.laser_cycles is None:
            raise Refusal(
                "cover_glass_crosstalk: laser_cycles is missing, expected the number of laser shots in a frame"
            )
        counts = counts + share * world.laser_cycles
    counts = counts + world.time_s * values["growth"] * counts
    arrival_s = (1 - values["together"]) * world.time_zero_s + values["together"] * world.time_zero_s.mean()
    second_s = arrival_s + values["delay"] + values["again_later"]
    inside = pulse_from_elsewhere(world, np.maximum(counts, 0) * world.boost, arrival_s + values["delay"], rng)
    inside = inside.and_also(
        pulse_from_elsewhere(world, np.maximum(counts, 0) * world.boost * values["again"], second_s, rng)
    )
    late_s = values["longer"] * rng.standard_normal(len(inside))
    late_s += values["trail"] * rng.standard_exponential(len(inside))
    return photons.and_also(replace(inside, time_s=inside.time_s + late_s))

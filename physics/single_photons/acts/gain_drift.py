"""`gain_drift`: more photons come, or fewer, the later it is."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.walking import height_by_now
from physics.single_photons.world import World


def world(world: World, values: Values, rng: np.random.Generator) -> World:
    """All light of the laser in one proportion, and the background in a power of it."""
    cold = np.exp(-world.time_s / values["tau"])
    times = np.exp(values["rate"] * world.time_s) * np.exp(values["warmup"]) ** cold
    times = times * np.exp(values["curve"]) ** (world.time_s * world.time_s)
    times = times * np.exp(height_by_now(values, world.time_s))
    dark = world.background * times ** values["background"]
    return replace(world, gain=world.gain * times, boost=world.boost * times, background=dark)

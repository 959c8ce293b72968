"""`gain_drift`: more photons come, or fewer, the later it is."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.world import World


def world(world: World, values: Values, rng: np.random.Generator) -> World:
    """Everything that is counted in this frame, in one proportion."""
    cold = np.exp(-world.time_s / values["tau"])
    times = np.exp(values["rate"] * world.time_s) * np.exp(values["warmup"]) ** cold
    return replace(world, gain=world.gain * times, boost=world.boost * times, background=world.background * times)

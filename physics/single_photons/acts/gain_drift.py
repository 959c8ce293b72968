"""`gain_drift`: more photons come, or fewer, the later it is."""

from dataclasses import replace

import numpy as np
from scipy.interpolate import make_interp_spline

from physics.effect import Values
from physics.single_photons.world import World


def world(world: World, values: Values, rng: np.random.Generator) -> World:
    """All light of the laser in one proportion, and the background in a power of it."""
    cold = np.exp(-world.time_s / values["tau"])
    times = np.exp(values["rate"] * world.time_s) * np.exp(values["warmup"]) ** cold
    times = times * np.exp(values["curve"]) ** (world.time_s * world.time_s)
    times = times * np.exp(_walk(values, world.time_s / values["every"]))
    dark = world.background * times ** values["background"]
    return replace(world, gain=world.gain * times, boost=world.boost * times, background=dark)


def _walk(values: Values, levels: float) -> float:
    """What the logarithm has come to so many levels after the start: a curve that is straight at both ends."""
    height = {0.0: 0.0}
    for k in range(1, 7):
        height[float(k)] = values[f"level_{k}"]
        height[k - 0.5] = values[f"between_{k}"] + (height[k - 1.0] + height[float(k)]) / 2
    places = sorted(height)
    curve = make_interp_spline(places, [height[at] for at in places], k=3, bc_type="natural")
    return float(curve(min(levels, 6.0)))

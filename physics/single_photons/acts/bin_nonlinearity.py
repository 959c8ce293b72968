"""`bin_nonlinearity`: photons are told apart by edges that are not where they should be."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.world import Photons, World


def detected(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """A photon between two true edges is given the time it would have between the same two, were they even."""
    number = np.arange(world.bins + 1)
    wander = values["slope"] * world.bins / np.pi * np.sin(np.pi * number / world.bins)
    edges = number + wander + np.where(number % 2 == 0, values["alternation"], -values["alternation"])
    edges += np.append(np.broadcast_to(values["edge"], world.bins), 0)
    height = np.hypot(values["wave_cos"], values["wave_sin"])
    late = np.arctan2(values["wave_sin"], values["wave_cos"])
    edges += height * np.cos(number * 2 * np.pi / values["period"] - late) - values["wave_cos"]
    edges[0], edges[-1] = 0, world.bins
    true = photons.time_s / world.bin_width_s
    inside = (true >= 0) & (true < world.bins)
    told = np.where(inside, np.interp(true, edges, number), true)
    return replace(photons, time_s=told * world.bin_width_s)

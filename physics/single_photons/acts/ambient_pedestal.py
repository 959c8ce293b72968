"""`ambient_pedestal`: more background."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.draw import by_zone
from physics.single_photons.walking import height_by_now
from physics.single_photons.world import World


def world(world: World, values: Values, rng: np.random.Generator) -> World:
    """As many counts more in each bin by the time of this frame."""
    turn = np.exp(2j * np.pi * values["frequency"] * world.time_s)
    swung = values["swing_sin"] * turn.imag + values["swing_cos"] * turn.real
    lamp = by_zone(world, values["level"]) * np.exp(height_by_now(values, world.time_s))
    more = lamp + values["growth"] * world.time_s + values["more"] * world.background
    white = np.where(np.isfinite(world.depth_m + world.reflectance), world.reflectance, 0)
    seen = (world.weights * white).sum(axis=(1, 2)) / world.weights.sum(axis=(1, 2)).mean()
    more = more + swung + values["lit"] * seen
    return replace(world, background=np.maximum(world.background + more, 0))

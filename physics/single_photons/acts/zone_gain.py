"""`zone_gain`: zones let more or less of the laser's photons through."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.draw import by_zone
from physics.single_photons.world import Photons, World


def world(world: World, values: Values, rng: np.random.Generator) -> World:
    """As many photons for all as the most sensitive zone counts: none is there twice."""
    factors = _factors(world, values)
    most, dark = max(1.0, float(factors.max())), world.background * factors ** values["ambient"]
    return replace(world, gain=world.gain * most, boost=world.boost * most, background=dark)


def photons(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Of these the others lose their part."""
    factors = _factors(world, values)
    passed = factors / max(1.0, float(factors.max()))
    return photons.only(rng.random(len(photons)) < passed[photons.zone])


def _factors(world: World, values: Values) -> np.ndarray:
    """(P,) factor of each zone."""
    factors = np.array(by_zone(world, values["factor"]), float)
    alone = int(values["zone"] + 0.5)
    if alone < len(factors):
        factors[alone] *= np.exp(values["one"])
    grid = factors.reshape(world.zone_grid)
    row, column = (np.linspace(-1, 1, n) if n > 1 else np.array([-1.0]) for n in grid.shape)
    grid *= np.exp(values["down"] * row)[:, None] * np.exp(values["across"] * column)
    away = np.hypot(*np.meshgrid(*(np.arange(n) - (n - 1) / 2 for n in grid.shape), indexing="ij"))
    grid *= np.exp(values["bow"] * (away / max(away.max(), 1e-9)) ** 2)
    grid[::2, ::2] *= np.exp(values["alternate"])
    grid[1::2, 1::2] *= np.exp(values["alternate"])
    grid[::2, 1::2] /= np.exp(values["alternate"])
    grid[1::2, ::2] /= np.exp(values["alternate"])
    return factors

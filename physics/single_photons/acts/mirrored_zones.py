"""`mirrored_zones`: photons are counted by another zone than the one whose map they fell on."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.world import NO_PIXEL, Photons, World


def photons(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Each photon from the scene has its zone put in another order or not, by chance; then it or its line exchanged for
    another; then its row mirrored, its column, and its zone counted down the columns.

    The zone that counts it times it by its own clock, unless clocks come along. What never was in the field of view has
    no map to be on.
    """
    rows, columns = world.zone_grid
    zone = _in_order(photons.zone, world.zone_grid, values, rng)
    row, column = np.divmod(_in_pairs(zone, world.zone_grid, values, rng), columns)
    row = np.where(rng.random(len(photons)) < values["rows"], rows - 1 - row, row)
    column = np.where(rng.random(len(photons)) < values["columns"], columns - 1 - column, column)
    turned = rng.random(len(photons)) < values["transposed"]
    counted = np.where(turned, column * rows + row, row * columns + column)
    zone = np.where(photons.pixel == NO_PIXEL, photons.zone, counted).astype(photons.zone.dtype)
    later = world.time_zero_s[zone] - world.time_zero_s[photons.zone]
    time = photons.time_s + (1 - values["clocks"]) * later
    return replace(photons, zone=zone, time_s=time)


def _in_order(zone: np.ndarray, grid: tuple[int, int], values: Values, rng: np.random.Generator) -> np.ndarray:
    """(N,) zones that take the place of these, for each photon by chance; these where what is given is no order."""
    taker = {round(float(place)): one for one, place in enumerate(np.atleast_1d(values["place"]))}
    if sorted(taker) != list(range(grid[0] * grid[1])):
        return zone
    other = np.array([taker[place] for place in range(len(taker))])[zone]
    return np.where(rng.random(len(zone)) < values["reordered"], other, zone)


def _in_pairs(zone: np.ndarray, grid: tuple[int, int], values: Values, rng: np.random.Generator) -> np.ndarray:
    """(N,) zones after two of them, two rows or two columns are exchanged, for each photon by chance."""
    zone = zone.copy()
    row, column = np.divmod(zone, grid[1])
    pair = [round(values[name]) for name in ("first", "second")]
    for name, line in (("zones_exchanged", zone), ("rows_exchanged", row), ("columns_exchanged", column)):
        if values[name]:
            chance = rng.random(len(zone)) < values[name]
            other = np.where(line == pair[0], pair[1], np.where(line == pair[1], pair[0], line))
            line[...] = np.where(chance, other, line)
            if name == "zones_exchanged":
                row, column = np.divmod(zone, grid[1])
    return row * grid[1] + column

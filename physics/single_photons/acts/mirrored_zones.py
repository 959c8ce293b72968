"""`mirrored_zones`: photons are counted by another zone than the one whose map they fell on."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.world import NO_PIXEL, Photons, World


def photons(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Each photon from the scene is counted by another zone or not.

    The zone that counts it times it by its own clock, unless clocks come along. What never was in the field of view has
    no map to be on.
    """
    counted = _counting(photons.zone, world.zone_grid, values, rng)
    zone = np.where(photons.pixel == NO_PIXEL, photons.zone, counted).astype(photons.zone.dtype)
    later = world.time_zero_s[zone] - world.time_zero_s[photons.zone]
    return replace(photons, zone=zone, time_s=photons.time_s + (1 - values["clocks"]) * later)


def detected(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """What comes from no pixel is counted by another zone where backgrounds come along."""
    moves = (photons.pixel == NO_PIXEL) & (rng.random(len(photons)) < values["levels"])
    counted = _counting(photons.zone, world.zone_grid, values, rng)
    return replace(photons, zone=np.where(moves, counted, photons.zone).astype(photons.zone.dtype))


def _counting(zone: np.ndarray, grid: tuple[int, int], values: Values, rng: np.random.Generator) -> np.ndarray:
    """(N,) zones that count photons of these: put in another order or not, by chance; then each or its line exchanged
    for another; then its row mirrored, its column, and counted down the columns.
    """
    rows, columns = grid
    row, column = np.divmod(_in_pairs(_in_order(zone, grid, values, rng), grid, values, rng), columns)
    row = np.where(rng.random(len(zone)) < values["rows"], rows - 1 - row, row)
    column = np.where(rng.random(len(zone)) < values["columns"], columns - 1 - column, column)
    turned = rng.random(len(zone)) < values["transposed"]
    return np.where(turned, column * rows + row, row * columns + column)


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

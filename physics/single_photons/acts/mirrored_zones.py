"""`mirrored_zones`: photons are counted by another zone than the one whose map they fell on."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.world import NO_PIXEL, Photons, World
from recordings.refusal import Refusal


def photons(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Each photon from the scene has its row, its column, and the two among themselves exchanged or not, by chance.

    The zone that counts it times it by its own clock. What never was in the field of view has no map to be on.
    """
    rows, columns = world.zone_grid
    if values["transposed"] and rows != columns:
        raise Refusal(
            f"mirrored_zones: transposed is {values['transposed']:g} on {rows} x {columns} zones, expected 0 there"
        )
    row, column = np.divmod(photons.zone, columns)
    row = np.where(rng.random(len(photons)) < values["rows"], rows - 1 - row, row)
    column = np.where(rng.random(len(photons)) < values["columns"], columns - 1 - column, column)
    turned = rng.random(len(photons)) < values["transposed"]
    row, column = np.where(turned, column, row), np.where(turned, row, column)
    zone = np.where(photons.pixel == NO_PIXEL, photons.zone, row * columns + column).astype(photons.zone.dtype)
    time = photons.time_s + world.time_zero_s[zone] - world.time_zero_s[photons.zone]
    return replace(photons, zone=zone, time_s=time)

"""`bin_phase`: photons count by where in its bin their pulse falls."""

from dataclasses import replace

import numpy as np
from scipy.constants import speed_of_light

from physics.effect import Values
from physics.single_photons.draw import way_m
from physics.single_photons.world import NO_PIXEL, Photons, World


def world(world: World, values: Values, rng: np.random.Generator) -> World:
    """As many photons for all as are counted at the best phase."""
    most = 1 + values["depth"]
    return replace(world, gain=world.gain * most, boost=world.boost * most)


def photons(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Of these the others lose their part; a photon from no pixel counts as at a mean phase.

    A pulse's place is that of its light's way there and back, by the time zero of its zone. Delays that come later
    are not in it.
    """
    depth = values["depth"]
    turn = (world.time_zero_s[photons.zone] + way_m(photons, world) / speed_of_light) / world.bin_width_s
    wave = np.where(photons.pixel == NO_PIXEL, 0, np.cos(2 * np.pi * (turn - values["phase"])))
    return photons.only(rng.random(len(photons)) * (1 + depth) < 1 + depth * wave)

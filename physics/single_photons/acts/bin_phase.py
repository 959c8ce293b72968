"""`bin_phase`: photons count by where in its bin their pulse falls."""

from dataclasses import replace

import numpy as np
from scipy.constants import speed_of_light

from physics.effect import Values
from physics.single_photons.draw import by_zone, way_m
from physics.single_photons.world import NO_PIXEL, Photons, World


def world(world: World, values: Values, rng: np.random.Generator) -> World:
    """As many photons for all as are counted at the best phase."""
    most = (1 + np.max(values["depth"]) * _highest(values)) * (1 + np.max(values["whole"]) * _highest(values))
    return replace(world, gain=world.gain * most, boost=world.boost * most)


def photons(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Of these the others lose their part; a photon from no pixel counts as at a mean phase.

    A pulse's place is that of its light's way there and back, by the time zero of its zone; that of a whole pulse is
    the mean over what surfaces send to the zone. Delays that come later are not in it.
    """
    depth, whole = (by_zone(world, values[name])[photons.zone] for name in ("depth", "whole"))
    pixel = photons.pixel != NO_PIXEL
    turn = (world.time_zero_s[photons.zone] + way_m(photons, world) / speed_of_light) / world.bin_width_s
    wave = np.where(pixel, _shape(values, turn), 0)
    kept = rng.random(len(photons)) * (1 + np.max(values["depth"]) * _highest(values)) < 1 + depth * wave
    swell = np.where(pixel, _shape(values, _mean_turns(world))[photons.zone], 0)
    kept &= rng.random(len(photons)) * (1 + np.max(values["whole"]) * _highest(values)) < 1 + whole * swell
    return photons.only(kept)


def _shape(values: Values, turn: np.ndarray) -> np.ndarray:
    """A periodic function of the phase by its first three Fourier coefficients."""
    once = np.exp(2j * np.pi * (turn - values["phase"]))
    higher = [(values[f"cos_{k}"] - 1j * values[f"sin_{k}"]) * once**k for k in (2, 3)]
    return (once + sum(higher)).real


def _highest(values: Values) -> float:
    """What that is nowhere above."""
    return 1 + sum(abs(values[f"{of}_{k}"]) for of in ("cos", "sin") for k in (2, 3))


def _mean_turns(world: World) -> np.ndarray:
    """(P,) bins from the start of the first to where the middle of a zone's light arrives."""
    sent = world.reflectance * world.gloss * world.cosine / world.range_m**2
    sent = np.where(np.isfinite(sent) & (world.cosine > 0), sent, 0)
    share = world.weights * sent
    way = (share * np.nan_to_num(2 * world.range_m)).sum(axis=(1, 2)) / np.maximum(share.sum(axis=(1, 2)), 1e-300)
    return (world.time_zero_s + way / speed_of_light) / world.bin_width_s

"""`pile_up`: a channel's first photon of a shot hides the others."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.draw import by_zone, in_window
from physics.single_photons.world import Photons, World
from recordings.refusal import Refusal


def detected(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """The first of each channel and shot, and those after it when that is alive again.

    Photons fall on their zone's 1/share channels at random. Where 1/share is not whole, the last of the channels is
    alive in a part of the shots only. Shots that nobody counted are as many as `per_count` says. Photons of other zones
    of a converter hide a zone's own, each with the chance `partner`.
    """
    rate = by_zone(world, values["per_count"])
    if np.any(values["share"]):
        if world.laser_cycles is None:
            raise Refusal("pile_up: laser_cycles is missing, expected the number of laser shots in a frame")
        rate = rate + by_zone(world, values["share"]) / world.laser_cycles
    # Places in so many shots and channels; of a million millions there is no dead time to speak of.
    places = np.maximum(1, np.rint(1 / np.maximum(rate, 1e-12))).astype(np.int64)
    opened = photons.only(in_window(photons, world))
    own = len(opened)
    opened = _with_others(opened, world, values, rng)
    # Shot and channel in one number: the remainder by the number of shots, and the quotient.
    chance = rng.integers(places[opened.zone])
    place = opened.zone * (places.max() + 1) + chance
    kept = np.zeros(len(opened), bool)
    waiting = np.argsort(opened.time_s)
    while len(waiting):
        _, first, which = np.unique(place[waiting], return_index=True, return_inverse=True)
        counted = waiting[first]
        kept[counted] = True
        waiting = waiting[opened.time_s[waiting] > opened.time_s[counted][which] + values["dead"]]
    kept |= rate[opened.zone] == 0
    kept[own:] = False
    return replace(opened, shot=chance % (world.laser_cycles or 1)).only(kept)


def _with_others(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """These, and after them those of others as if they fell on each of the zones that they keep busy."""
    zones = np.arange(world.zones)
    number = by_zone(world, values["converter"]).round().astype(int)
    # In order two by two, unless somebody says how; the last of an odd number is alone.
    number = np.where(number < 0, world.zones * 1_000_000 + zones // 2, number)
    added = photons
    for apart in range(1, world.zones):
        other = (photons.zone + apart) % world.zones
        there = (number[other] == number[photons.zone]) & (rng.random(len(photons)) < values["partner"])
        added = added.and_also(replace(photons, zone=other).only(there))
    return added

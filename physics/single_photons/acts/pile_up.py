"""`pile_up`: a channel's first photon of a shot hides the others."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.draw import by_zone, in_window
from physics.single_photons.world import Photons, World
from recordings.refusal import Refusal


def detected(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """The first of each channel and shot; photons fall on their zone's 1/share channels at random.

    Where 1/share is not whole, the last of the channels is alive in a part of the shots only.
    """
    if world.laser_cycles is None:
        raise Refusal("pile_up: laser_cycles is missing, expected the number of laser shots in a frame")
    share = by_zone(world, values["share"])
    # A zone of a million channels or more has no dead time to speak of, and one of share 0 has none.
    places = np.maximum(1, np.rint(world.laser_cycles / np.maximum(share, 1e-6))).astype(np.int64)
    opened = photons.only(in_window(photons, world))
    # Shot and channel in one number: the remainder by the number of shots, and the quotient.
    chance = rng.integers(places[opened.zone])
    place = opened.zone * (places.max() + 1) + chance
    by_time = np.argsort(opened.time_s)
    _, first = np.unique(place[by_time], return_index=True)
    kept = np.zeros(len(opened), bool)
    kept[by_time[first]] = True
    kept |= share[opened.zone] == 0
    return replace(opened, shot=chance % world.laser_cycles).only(kept)

"""`window_clipping`: counts outside a window are thrown away."""

import numpy as np

from physics.effect import Values
from physics.single_photons.draw import by_zone, in_window
from physics.single_photons.world import NO_PIXEL, Photons, World


def detected(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Where the background is to stay, photons are thrown away one by one.

    Those from no pixel are taken for background then; where it does not stay they are told by nothing, see `counted`.
    """
    if values["background"] == 1:
        return photons
    place = np.clip(photons.time_s / world.bin_width_s, 0, world.bins - 1).astype(int)
    thrown = 1 - _kept(world, values)[photons.zone, place]
    spared = np.where(photons.pixel == NO_PIXEL, values["background"], 1)
    return photons.only((rng.random(len(photons)) >= thrown * spared) & in_window(photons, world))


def counted(counts: np.ndarray, world: World, values: Values, rng: np.random.Generator) -> np.ndarray:
    """A count stands for a photon somewhere in its bin, and is kept where that is in the window."""
    return rng.binomial(counts, _kept(world, values)) if values["background"] == 1 else counts


def _kept(world: World, values: Values) -> np.ndarray:
    """(P, T) share of each bin's counts: between an edge that opens and one that closes."""
    bins, ends = np.arange(world.bins), np.arange(world.bins, 0, -1)
    inside = []
    for early, late in zip(by_zone(world, values["early"]), by_zone(world, values["late"]), strict=True):
        opens = np.interp(bins, [early - values["softness"], early], [0, 1])
        closes = np.interp(ends - 1, [late - values["softness"], late], [0, 1])
        inside.append(np.maximum(opens + closes - 1, 0))
    return 1 - values["lost"] * (1 - np.stack(inside))

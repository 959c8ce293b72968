"""`window_clipping`: counts outside a window are thrown away."""

import numpy as np

from physics.effect import Values
from physics.single_photons.draw import by_zone, counts_of, in_window
from physics.single_photons.world import NO_PIXEL, Photons, World


def detected(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Where the background is to stay, photons are thrown away one by one.

    Those from no pixel are taken for background then; where it does not stay they are told by nothing, see `counted`.
    Where the window is summed all others of a zone are kept as often as one of them is in it.
    """
    if values["background"] == 1 and not values["summed"]:
        return photons
    place = np.clip(photons.time_s / world.bin_width_s, 0, world.bins - 1).astype(int)
    kept = _kept(world, values, counts_of(photons, world))[photons.zone, place]
    none, here = photons.pixel == NO_PIXEL, in_window(photons, world)
    chance = np.where(none, 1 - values["background"] * (1 - kept), kept)
    if values["summed"]:
        seen = here & ~none
        inside = np.bincount(photons.zone[seen], kept[seen], world.zones)
        share = inside / np.maximum(np.bincount(photons.zone[seen], minlength=world.zones), 1)
        chance += values["summed"] * (np.where(none, 1, share[photons.zone]) - chance)
    return photons.only((rng.random(len(photons)) < chance) & here)


def counted(counts: np.ndarray, world: World, values: Values, rng: np.random.Generator) -> np.ndarray:
    """A count stands for a photon somewhere in its bin, and is kept where that is in the window."""
    by_count = values["background"] == 1 and not values["summed"]
    return rng.binomial(counts, _kept(world, values, counts)) if by_count else counts


def _kept(world: World, values: Values, counts: np.ndarray) -> np.ndarray:
    """(P, T) share of each bin's counts (P, T): between an edge that opens and one that closes, and about the most."""
    bins, inside = np.arange(world.bins), []
    for early, late in zip(by_zone(world, values["early"]), by_zone(world, values["late"]), strict=True):
        opens, closes = _opened(values, early, bins), _opened(values, late, bins)[::-1]
        inside.append(np.maximum(opens + closes - 1, 0))
    kept = 1 - values["lost"] * (1 - np.stack(inside))
    for share, of_zone in zip(kept, counts, strict=True):
        from_top = bins - int(np.argmax(of_zone))
        reaches = np.where(from_top < 0, values["before"], values["after"])
        out = np.interp(np.abs(from_top) - reaches, [0, 1], [0, 1])
        share -= np.minimum(values["aside"] * out, share)
    return kept


def _opened(values: Values, edge: float, bins: np.ndarray) -> np.ndarray:
    """(T,) how far a window has opened at bins after its start; a gate that rises by tanh is the rounded one."""
    if edge == 0:
        return np.ones(len(bins))
    wide = values["softness"]
    ramp = np.interp(bins, [edge - wide, edge], [0, 1])
    rising = (1 + np.tanh(2 * (bins - edge + wide / 2) / wide)) / 2
    return ramp + values["rounded"] * (rising - ramp)

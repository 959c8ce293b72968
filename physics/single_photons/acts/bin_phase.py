"""`bin_phase`: photons count by where in its bin their pulse falls."""

from dataclasses import replace

import numpy as np
from scipy.constants import speed_of_light

from physics.effect import Values
from physics.single_photons.acts.parallax import calibration_depth
from physics.single_photons.draw import by_zone, way_m
from physics.single_photons.world import NO_PIXEL, Photons, World

# A step of the pulse is so many pieces, and places in a bin are so many.
PIECES, PLACES = 50, 200
# The height of a histogram is that of so many bins to either side.
BESIDE = 1 / 32


def world(world: World, values: Values, rng: np.random.Generator) -> World:
    """As many photons for all as are counted at the best phase; where maps hold rings, zones look without them."""
    if values["ringed"]:
        world = _without_rings(world, values["ringed"], values["taken_at"] or calibration_depth(world))
    most = (1 + np.max(values["depth"]) * _highest(values)) * _most_of_whole(values)
    if 0 < values["about"] < 1:  # Then they are drawn twice.
        most *= _most_of_whole(values)
    most *= max(float(_fullest(world, values["peaked"]).max()), 1.0)
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
    own, beside = _by_zone_alone(values), min(values["about"], 1)
    if beside < 1:
        mean = _mean_turns(world, values["highest"], values["within"])
        swell = (1 - beside) * whole * _shape(values, mean)[photons.zone]
        swell = swell + (own * np.exp(2j * np.pi * mean)).real[photons.zone]
        kept &= rng.random(len(photons)) * _most_of_whole(values) < 1 + np.where(pixel, swell, 0)
    if beside:
        swell = beside * whole * _shape(values, _centroids(world, values["about"]))[photons.zone]
        kept &= rng.random(len(photons)) * _most_of_whole(values) < 1 + np.where(pixel, swell, 0)
    peaked = _fullest(world, values["peaked"])
    kept &= rng.random(len(photons)) * max(float(peaked.max()), 1.0) < np.where(pixel, peaked[photons.zone], 1)
    return photons.only(kept)


def _without_rings(world: World, power: float, depth_m: float) -> World:
    """Zones that see as their maps say over what one pulse in the scan left in its fullest bin, to a power.

    Of a pulse that is drawn as many narrow pieces, at places in a bin that go all through it; over their mean.
    """
    if np.isinf(depth_m):
        return world
    places, fullest = _fullest_by_place(world)
    plane = replace(world, depth_m=np.full_like(world.depth_m, depth_m)).range_m
    turn = (world.time_zero_s[:, None, None] + 2 * plane / speed_of_light) / world.bin_width_s
    left = np.interp(turn % 1, places, fullest, period=1) / fullest.mean()
    return replace(world, weights=world.weights / left**power)


def _pieces(world: World) -> tuple[np.ndarray, np.ndarray]:
    """Times and parts of narrow pieces of the pulse, whose sum is 1."""
    step = world.pulse_time_s[1] - world.pulse_time_s[0]
    pieces = (world.pulse_time_s[:, None] + step * ((np.arange(PIECES) + 0.5) / PIECES - 0.5)).ravel()
    return pieces, np.repeat(world.pulse / PIECES, PIECES)


def _fullest_by_place(world: World) -> tuple[np.ndarray, np.ndarray]:
    """Places in a bin, and what part of a pulse that arrives there is in its fullest bin."""
    (pieces, part), places = _pieces(world), (np.arange(PLACES) + 0.5) / PLACES
    bins = [np.floor(pieces / world.bin_width_s + place).astype(int) for place in places]
    return places, np.array([np.bincount(at - at.min(), part).max() for at in bins])


def _fullest(world: World, power: float) -> np.ndarray:
    """(P,) what part of each zone's pulse is in its fullest bin, over the mean of a pulse alone, to a power."""
    if not power:
        return np.ones(world.zones)
    _, alone = _fullest_by_place(world)
    found = [bins.max() / bins.sum() if bins.any() else alone.mean() for bins in _histograms(world)]
    return (np.array(found) / alone.mean()) ** power


def _centroids(world: World, about: float) -> np.ndarray:
    """(P,) bins from the start of the first to the middle of each zone's histogram about its fullest bin.

    A bin in which `about` ends counts in part.
    """
    found = []
    for bins in _histograms(world):
        away = np.abs(np.arange(world.bins) - np.argmax(bins))
        near = bins * np.interp(away - about, [0, 1], [1, 0])
        found.append(float(np.average(np.arange(world.bins) + 0.5, weights=near)) if near.any() else 0.0)
    return np.array(found)


def _histograms(world: World) -> np.ndarray:
    """(P, T) what surfaces send each zone, by bin, of a pulse that is drawn as many narrow pieces."""
    pieces, part = _pieces(world)
    found = np.zeros((world.zones, world.bins))
    for bins, turns, share in zip(found, *_returns(world), strict=True):
        for turn, sent in zip(turns[share > 0], share[share > 0], strict=True):
            at = np.floor(turn + pieces / world.bin_width_s).astype(int)
            within = (at >= 0) & (at < world.bins)
            bins += sent * np.bincount(at[within], part[within], world.bins)
    return found


def _shape(values: Values, turn: np.ndarray) -> np.ndarray:
    """A periodic function of the phase by its first three Fourier coefficients."""
    once = np.exp(2j * np.pi * (turn - values["phase"]))
    higher = [(values[f"cos_{k}"] - 1j * values[f"sin_{k}"]) * once**k for k in (2, 3)]
    return (once + sum(higher)).real


def _by_zone_alone(values: Values) -> np.ndarray:
    """() or (P,) Fourier coefficient of a pulse's phase that each zone has of its own."""
    return np.asarray(values["along"]) - 1j * np.asarray(values["across"])


def _most_of_whole(values: Values) -> float:
    """How many times a whole pulse counts at most."""
    return 1 + float(np.max(values["whole"]) * _highest(values) + np.max(np.abs(_by_zone_alone(values))))


def _highest(values: Values) -> float:
    """What that is nowhere above."""
    return 1 + sum(abs(values[f"{of}_{k}"]) for of in ("cos", "sin") for k in (2, 3))


def _returns(world: World) -> tuple[np.ndarray, np.ndarray]:
    """(P, N) each: bins from the start of the first to where light of each pixel arrives, and how much of it."""
    sent = world.reflectance * world.gloss * world.cosine / world.range_m**2
    sent = np.where(np.isfinite(sent) & (world.cosine > 0), sent, 0)
    share = (world.weights * sent).reshape(world.zones, -1)
    way = 2 * np.nan_to_num(world.range_m).ravel() / speed_of_light
    return (world.time_zero_s[:, None] + way) / world.bin_width_s, share


def _mean_turns(world: World, highest: float, within: float) -> np.ndarray:
    """(P,) bins from the start of the first to where the middle of a zone's light arrives, or of its highest pulse."""
    return np.array([_middle(*zone, world, highest, within) for zone in zip(*_returns(world), strict=True)])


def _middle(turns: np.ndarray, share: np.ndarray, world: World, highest: float, within: float) -> float:
    """Mean of a zone's light; or of that within a part of three deviations of a pulse about where most is registered.

    A pulse is registered most when its own peak comes, not its mean.
    """
    every = float(np.average(turns, weights=share)) if share.any() else 0.0
    if not highest:
        return every
    steps = world.pulse_time_s / world.bin_width_s
    middle = float(np.average(steps, weights=world.pulse))
    peak = _most_registered(turns, share, world) - _most_registered(np.zeros(1), np.ones(1), world)
    near = within * max(3 * np.sqrt(np.average((steps - middle) ** 2, weights=world.pulse)), 1.0)
    # The logistic function: half of it counts at the end, a rim of a twentieth on, or of an eighth of a bin.
    beyond = (np.abs(turns - peak) - near) / max(near / 20, 1 / 8)
    told = share / (1 + np.exp(np.clip(beyond, -60, 60)))
    there = float(np.average(turns, weights=told)) if told.any() else peak
    return every + highest * (there - every)


def _most_registered(turns: np.ndarray, share: np.ndarray, world: World) -> float:
    """Bins from the start of the first to where most is registered of light that arrives at (N,) turns."""
    steps = world.pulse_time_s / world.bin_width_s
    edges = np.append(steps, 2 * steps[-1] - steps[-2]) - (steps[1] - steps[0]) / 2
    until = np.append(0, np.cumsum(world.pulse))

    def registered(at: np.ndarray) -> np.ndarray:
        # Light in a step about each time: of each pixel its cumulative's difference.
        return sum(
            part * (np.interp(at + BESIDE - turn, edges, until) - np.interp(at - BESIDE - turn, edges, until))
            for turn, part in zip(turns, share, strict=True)
            if part > 0
        )

    times = np.arange(turns.min() + steps[0], turns.max() + steps[-1], BESIDE)
    about = times[np.argmax(registered(times))] + np.linspace(-2 * BESIDE, 2 * BESIDE, 401)
    return float(about[np.argmax(registered(about))])

"""`bin_nonlinearity`: photons are told apart by edges that are not where they should be, or by gates of their own."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.world import Photons, World


def world(world: World, values: Values, rng: np.random.Generator) -> World:
    """As many photons for all bins as the widest counts, background and all."""
    most = _most(world, values)
    return replace(world, gain=world.gain * most, boost=world.boost * most, background=world.background * most)


def detected(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Some photons are told by edges: one between two true edges gets the time it would have, were they even.

    The others are counted, or not, by how wide the bin is in which they are.
    """
    late, widths = _late(world, values), _widths(world, values)
    true = photons.time_s / world.bin_width_s
    inside = (true >= 0) & (true < world.bins)
    by_edges = rng.random(len(photons)) * _most_in_place(world, values) < values["moved"]
    told = true.copy()
    for zone in range(world.zones):
        edges = np.arange(world.bins + 1) + late[zone]
        edges[0], edges[-1] = 0, world.bins
        some = inside & by_edges & (photons.zone == zone)
        told[some] = np.interp(true[some], edges, np.arange(world.bins + 1))
    place = photons.zone, np.clip(told, 0, world.bins - 1).astype(int)
    # Of those that no edge tells, there are as many as the widest bin in place would count.
    left = _most_in_place(world, values) - values["moved"]
    open_for = np.maximum(1 + np.diff(late), 0)[place] * (1 - values["moved"]) / (left if left > 0 else 1)
    kept = by_edges | (rng.random(len(photons)) < open_for)
    kept &= rng.random(len(photons)) < (widths / widths.max())[place]
    return replace(photons, time_s=told * world.bin_width_s).only(kept | ~inside)


def _late(world: World, values: Values) -> np.ndarray:
    """(P, T + 1) bins."""
    number = np.arange(world.bins + 1)
    late = values["slope"] * world.bins / np.pi * np.sin(np.pi * number / world.bins)
    late += np.where(number % 2 == 0, values["alternation"], -values["alternation"])
    late += np.append(np.broadcast_to(values["edge"], world.bins), 0)
    height, lag = np.hypot(values["wave_cos"], values["wave_sin"]), np.arctan2(values["wave_sin"], values["wave_cos"])
    late += height * np.cos(number * 2 * np.pi / values["period"] - lag) - values["wave_cos"]
    taps = np.append(0, [values[f"tap_{k}"] for k in range(1, 8)])
    for edge in range(1, world.bins + 1):
        late[edge:] += taps[(edge - 1) % 8] - taps.sum() / 8
    return late + np.column_stack([_by_zone(world, values["zone_edge"]), np.zeros(world.zones)])


def _widths(world: World, values: Values) -> np.ndarray:
    """(P, T) of bins beside what edges make of them."""
    return 1 + np.broadcast_to(values["width"], world.bins) + _by_zone(world, values["zone_width"])


def _by_zone(world: World, numbers: float | np.ndarray) -> np.ndarray:
    """(P, T) numbers of every zone's bins, zone by zone, or one for all."""
    return np.broadcast_to(np.ravel(numbers), world.zones * world.bins).reshape(world.zones, world.bins)


def _most_in_place(world: World, values: Values) -> float:
    """How many photons there must be for each that an even bin counts, edges that move and those that do not."""
    return values["moved"] + (1 - values["moved"]) * max(1.0, 1 + float(np.diff(_late(world, values)).max()))


def _most(world: World, values: Values) -> float:
    """And for bins that are wider by themselves."""
    return _most_in_place(world, values) * float(_widths(world, values).max())

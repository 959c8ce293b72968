"""Materials told apart by the reflectance that is assumed of them, whatever their shape.

What was painted alike, in a scene file or by hand, has one value in many pixels; what was guessed from colours scatters
about that of its dye. Both are modes of the distribution of reflectance, told apart where it is thin between them. Two
that lie beside each other everywhere on the same things are a pattern, as of tiles: one material.
"""

from functools import lru_cache
from itertools import pairwise

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.signal import find_peaks
from scipy.sparse.csgraph import connected_components

# Part of all pixels from which on one value, or one mode, is a material of its own.
VALUE, MODE = 0.003, 0.01
# One value stands out where it is so many times as frequent as those within a hundredth, in log reflectance.
STANDS_OUT, BESIDE = 10.0, 0.01
# Steps of the distribution of log reflectance, by how many of them it is smoothed, and how deep a valley must be
# between two modes, as a part of the lower.
STEP, SMOOTH, VALLEY = 0.02, 1.5, 0.5
# Part of its edges at which one material of a pattern meets the other, how alike they are spread over things, and how
# many times the side of a square as large as the smaller their common edge is long.
MIXED, TOGETHER, WOVEN = 0.4, 0.8, 3.0
# More pixels than these are drawn at even distances.
MOST_PIXELS = 1_000_000
# Reflectance that is as good as none.
DARKEST = 1e-4


def materials(reflectance: np.ndarray, surfaces: np.ndarray) -> np.ndarray:
    """(F, H, W) int32 number of the material at each pixel, from 1 in order of their pixels; 0 where it has few.

    reflectance: (F, H, W) 0 to 1, 0 or NaN where unknown. surfaces: (F, H, W) int numbers of things told apart
    otherwise.
    """
    return _materials(_Same(reflectance), _Same(surfaces))


def parts(surfaces: np.ndarray, materials: np.ndarray) -> np.ndarray:
    """Numbers, like these, from 1 in order of their pixels, of what is one surface of one material; 0 where neither."""
    return _ranked(surfaces * (int(materials.max(initial=0)) + 1) + materials)


class _Same:
    """An array that is the same only as itself, so that what was made of it is kept as long as needed."""

    def __init__(self, values: np.ndarray) -> None:
        self.values = values

    def __hash__(self) -> int:
        return id(self.values)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Same) and other.values is self.values


@lru_cache(maxsize=4)
def _materials(reflectance: _Same, surfaces: _Same) -> np.ndarray:
    """See `materials`."""
    everywhere = np.nan_to_num(reflectance.values.ravel())
    known = everywhere > DARKEST
    drawn = everywhere[known][:: max(1, int(known.sum()) // MOST_PIXELS)]
    ends: list[tuple[float, float]] = []
    if len(drawn):
        values, counts = np.unique(drawn, return_counts=True)
        alone = _alone(np.log(values), counts, VALUE * len(drawn))
        ends = [(value, value) for value in values[alone]]
        ends += _modes(np.log(values[~alone]), counts[~alone], MODE * len(drawn))
    found = np.zeros(everywhere.shape, np.int32)
    # Single values last: they may lie within the mode of something else.
    for number, (low, high) in reversed(list(enumerate(ends, start=1))):
        there = known & (everywhere >= low) & (everywhere <= high)
        found[there] = number
    found = _patterns(found.reshape(reflectance.values.shape), surfaces.values)
    return _ranked(found)


def _ranked(numbers: np.ndarray) -> np.ndarray:
    """Numbers of 0 or more as those from 1 on, int32, the most frequent first; 0 stays."""
    many = np.bincount(numbers.ravel(), minlength=1)
    rank = np.zeros(len(many), np.int32)
    rank[1 + np.argsort(-many[1:], kind="stable")] = np.arange(1, len(many))
    return rank[numbers]


def _patterns(found: np.ndarray, surfaces: np.ndarray) -> np.ndarray:
    """Materials (F, H, W) of which those of one pattern have one number."""
    many = int(found.max(initial=0)) + 1
    touching = np.zeros((many, many))
    for one, other in ((found[:, 1:], found[:, :-1]), (found[..., 1:], found[..., :-1])):
        touching += np.bincount(one.ravel() * many + other.ravel(), minlength=many**2).reshape(many, many)
    touching += touching.T
    np.fill_diagonal(touching, 0)
    beside = touching / np.maximum(touching.sum(axis=1, keepdims=True), 1)
    things = int(surfaces.max(initial=0)) + 1
    on = np.bincount(found.ravel() * things + surfaces.ravel(), minlength=many * things).reshape(many, things)
    pixels = on.sum(axis=1) / len(found)
    woven = touching / len(found) > WOVEN * np.sqrt(np.minimum.outer(pixels, pixels))
    on = on / np.maximum(np.linalg.norm(on, axis=1, keepdims=True), 1)
    one = woven & (np.minimum(beside, beside.T) > MIXED) & (on @ on.T > TOGETHER)
    one[0] = one[:, 0] = False
    _, group = connected_components(one, directed=False)
    first = np.array([np.flatnonzero(group == g)[0] for g in group])
    return first[found]


def _alone(log: np.ndarray, counts: np.ndarray, least: float) -> np.ndarray:
    """Which of N values, by ascending logarithm, are so much more frequent than those about them."""
    first, last = np.searchsorted(log, log - BESIDE, "left"), np.searchsorted(log, log + BESIDE, "right")
    up_to = np.concatenate([[0], np.cumsum(counts)])
    others = up_to[last] - up_to[first] - counts
    usual = others / np.maximum(last - first - 1, 1)
    return (counts >= least) & (counts > STANDS_OUT * usual)


def _modes(log: np.ndarray, counts: np.ndarray, least: float) -> list[tuple[float, float]]:
    """Reflectances between which each mode lies that has pixels enough, from values by ascending logarithm."""
    if not len(log):
        return []
    edges = np.arange(log[0] - 4 * SMOOTH * STEP, log[-1] + 4 * SMOOTH * STEP, STEP)
    density = gaussian_filter1d(np.histogram(log, edges, weights=counts)[0].astype(float), SMOOTH)
    peaks, about = find_peaks(density, prominence=0)
    peaks = peaks[about["prominences"] >= VALLEY * density[peaks]]
    cuts = [edges[p + int(np.argmin(density[p:q])) + 1] for p, q in pairwise(peaks)]
    inside = zip([edges[0], *cuts], [*cuts, edges[-1]], strict=True)
    return [(np.exp(a), np.exp(b)) for a, b in inside if counts[(log >= a) & (log <= b)].sum() >= least]

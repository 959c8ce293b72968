"""A pulse that moves smoothly from frame to frame, on a path of its own: the likeliest path through frames and bins."""

import numpy as np
from numba import njit

from physics.effect import Values
from physics.rendering import Rendering
from physics.tracks import matched_parts
from physics.walk import BETWEEN, LEVELS, curve

# Bins by which the path's step from part to part may differ from none for a loss of half a deviance, and at most.
USUAL_BINS, MOST_BINS = 1.0, 6
# Turns in which zones are weighted by what the path has in them.
TURNS = 3


def curved_track(
    excess: np.ndarray, expected: np.ndarray, rendering: Rendering
) -> tuple[list[tuple[float, dict[str, float]]], float]:
    """Of the path along which most is in excess: where it begins, its levels, and seconds from each to the next.

    As far as levels alone tell, and with heights halfway to each (see `own_way`). excess: (F, P, T) recorded less
    expected counts. Nominal arrival, seconds from the start of bin 0; levels are later than that by so many seconds.
    No path where the session has no length, or nothing is in excess. It is the likeliest of a hidden Markov
    chain (Viterbi 1967, IEEE Trans. Inf. Theory 13, 260); levels are those of the nearest spline.
    """
    clock, time_s = rendering.clock, np.asarray(rendering.light.time_s, float)
    every = float(np.max(time_s)) / len(LEVELS)
    if not every > 0:
        return [], every
    matched, times = matched_parts(excess, expected, rendering)
    weight = np.ones(matched.shape[1])
    for _ in range(TURNS):
        seen = np.einsum("npt,p->nt", matched, weight / np.linalg.norm(weight))
        path = likeliest_path(np.maximum(seen, 0) ** 2 / 2, USUAL_BINS, MOST_BINS)
        along = matched[np.arange(len(path)), :, path]
        weight = np.maximum(along.mean(axis=0), 0)
        if not weight.any():
            return [], every
    trusted = np.sqrt(np.maximum(along @ weight, 0))
    found = []
    for halves in (1, 2):
        # A spline is linear in what it goes through.
        ways = curve(np.eye(halves * len(LEVELS) + 1), every / halves, times)
        heights = np.linalg.lstsq(ways * trusted[:, None], path * trusted, rcond=1e-6)[0] * clock.bin_width_s
        level = heights[::halves]
        levels = dict(zip(LEVELS, level[1:] - level[0], strict=True))
        if halves == 2:
            above = heights - curve(level, every, every / 2 * np.arange(len(heights)))
            levels |= dict(zip(BETWEEN, above[1::2], strict=True))
        found.append((float(heights[0] + clock.bin_width_s / 2), levels))
    return found, every


def own_way(values: Values, time_s: np.ndarray) -> np.ndarray:
    """(F,) heights of a natural cubic spline through 0 and levels at even times, and heights halfway to each.

    These are given above the spline through the levels alone, which is the same where they are 0.
    """
    level, above = np.array([0.0, *(values[name] for name in LEVELS)]), [values[name] for name in BETWEEN]
    if not any(above):
        return curve(level, values["every"], time_s)
    heights = curve(level, 1.0, np.arange(2 * len(level) - 1) / 2)
    heights[1::2] += above
    return curve(heights, values["every"] / 2, time_s)


@njit(cache=True)
def likeliest_path(gain, usual, most):
    """(N,) places of the path of most gain (N, T), less half the square of each step over `usual`; no step is longer
    than `most`.
    """
    parts, places = gain.shape
    total, came = gain[0].copy(), np.zeros((parts, places), np.int64)
    for n in range(1, parts):
        reached = np.empty(places)
        for t in range(places):
            best, where = -np.inf, t
            for s in range(max(t - most, 0), min(t + most + 1, places)):
                value = total[s] - 0.5 * ((t - s) / usual) ** 2
                if value > best:
                    best, where = value, s
            reached[t], came[n, t] = best + gain[n, t], where
        total = reached
    path = np.empty(parts, np.int64)
    path[-1] = np.argmax(total)
    for n in range(parts - 1, 0, -1):
        path[n - 1] = came[n, path[n]]
    return path

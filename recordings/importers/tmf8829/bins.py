"""Bin width and time zero of a TMF8829, which nothing published states, from the distances that the chip itself found.

Where a histogram has its highest bin, the chip reports a distance: a straight line through these pairs says how long a
bin is and where range 0 lies. The line is Theil and Sen's, of the median slope, so that zones in which the chip chose
another peak do not matter.
"""

from dataclasses import dataclass

import numpy as np
from scipy.constants import speed_of_light
from scipy.stats import theilslopes

# Pairs that are looked at; all pairs of these make slopes.
MOST = 1000
# A line through fewer bins, or further from the half of its points, is none.
FEWEST_BINS = 5
FARTHEST_BINS = 1.0
# Points further than thrice the median are left out of the next round.
ROUNDS = 4


@dataclass(frozen=True)
class Bins:
    """width_s: seconds. zero_s: arrival of a target at range 0 from the start of bin 0, seconds. pairs: it is from."""

    width_s: float
    zero_s: float
    pairs: int


def fitted(counts: np.ndarray, distance_m: np.ndarray) -> Bins | None:
    """From (N, T) histograms and (N,) distances, NaN where there is none; None where they lie on no line."""
    known = np.isfinite(distance_m) & (counts.max(axis=1) > 0)
    peak = centroid(counts[known])
    metres = distance_m[known]
    every = max(1, len(peak) // MOST)
    peak, metres = peak[::every], metres[::every]
    if len(peak) < FEWEST_BINS or np.ptp(peak) < FEWEST_BINS:
        return None
    near = np.ones(len(peak), bool)
    for _ in range(ROUNDS):
        slope, start = theilslopes(metres[near], peak[near])[:2]
        off = np.abs(metres - start - slope * peak)
        near = off <= 3 * np.median(off)
    if not slope > 0 or np.median(off) > FARTHEST_BINS * slope or np.ptp(peak[near]) < FEWEST_BINS:
        return None
    width_s = 2 * slope / speed_of_light
    return Bins(width_s, -start / slope * width_s, int(near.sum()))


def centroid(counts: np.ndarray) -> np.ndarray:
    """(N,) place of the highest bin and the two beside it in (N, T), in bins from the start of bin 0."""
    bins = counts.shape[1]
    near = np.clip(counts.argmax(axis=1)[:, None] + np.arange(-1, 2), 0, bins - 1)
    weights = np.take_along_axis(counts.astype(float), near, axis=1)
    return (weights * (near + 0.5)).sum(axis=1) / weights.sum(axis=1)

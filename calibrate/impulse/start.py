"""Where the search for a response begins: all frames laid over one another, shifted to their nominal arrivals."""

import numpy as np
from scipy.ndimage import uniform_filter1d

from physics.arrivals import Arrivals

# Of the peak; the response begins and ends where the stack falls below this for good, or below its own noise.
FAINT = 2e-4
NOISE_SIGMAS = 4.0
MARGIN_BINS = 2.0
# Light that arrives within so many bins, as a standard deviation, is one pulse; part of all that is hardly any.
NARROW_BINS, FEW = 3.0, 0.05


def stack(arrivals: Arrivals, counts: np.ndarray, alive: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Bins after the nominal arrival (B,), every quarter that a frame tells of; light per frame there; its error.

    Pedestals (the median of each histogram) are taken off; losses by dead time are made good. counts, alive: (F, P, T).
    Of zones and frames whose light all arrives at about one time, by its mean; where hardly any does, as two surfaces
    fill each zone, of those most of whose light does, by that.
    """
    bins, total = arrivals.bins, arrivals.light.sum(axis=2)
    nominal, alone = _nominal(arrivals)
    made_good = counts / np.maximum(alive, 0.02)
    pedestal = np.median(made_good, axis=2, keepdims=True)
    peak = (made_good - pedestal).max(axis=2)
    bright = (total > 0) & (peak > 0)
    bright = bright & alone if (bright & alone).any() else bright
    place = np.arange(bins) + 0.5 - nominal[..., None]
    cell = np.round(place[bright] * 4).astype(int)
    low = int(cell.min())
    index, size = (cell - low).ravel(), int(cell.max()) - low + 1
    seen = np.bincount(index, minlength=size)
    # Where nothing moves each zone tells of one place in a bin; of those between no frame does.
    told = np.flatnonzero(seen)
    # Bright frames are given their weight: sums of counts over sums of levels.
    level = np.bincount(index, np.repeat(peak[bright], bins), size)
    sums = np.bincount(index, (made_good - pedestal)[bright].ravel(), size)
    noise = np.bincount(index, made_good[bright].ravel() / np.maximum(alive[bright].ravel(), 0.02), size)
    sigma = np.sqrt(np.maximum(noise, seen)[told]) / level[told]
    return (told + low) / 4, sums[told] / level[told], sigma


def _nominal(arrivals: Arrivals) -> tuple[np.ndarray, np.ndarray]:
    """(F, P) nominal arrival of light, bins, and whether it is about the only one."""
    lattice, light = arrivals.lattice, arrivals.light
    knots = (lattice.first_s + lattice.step_s * np.arange(lattice.size)) / (lattice.step_s * lattice.per_bin)
    total = np.maximum(light.sum(axis=2), np.finfo(float).tiny)
    mean = light @ knots / total
    spread = np.sqrt(np.maximum(light @ knots**2 / total - mean**2, 0))
    if (spread < NARROW_BINS).mean() > FEW:
        return mean, spread < NARROW_BINS
    wide = int(NARROW_BINS * lattice.per_bin)
    around = uniform_filter1d(light, wide, axis=2, mode="constant") * wide
    top = around.argmax(axis=2)
    return knots[top], around.max(axis=2) > total / 2


def reach(places: np.ndarray, values: np.ndarray, sigma: np.ndarray, bins: int) -> tuple[float, float, float]:
    """Bins before the nominal arrival at which the response begins; of its peak, and its end, after it."""
    sure = np.where(np.abs(places) < bins / 2, values - NOISE_SIGMAS * sigma, 0)
    # Where one frame in a thousand looks, the largest value is no peak.
    peak = int(np.argmax(sure))
    up = sure > FAINT * sure[peak]
    low = high = peak
    while low > 0 and up[max(low - 2, 0) : low].any():
        low -= 1
    while high < len(up) - 1 and up[high + 1 : high + 5].any():
        high += 1
    return MARGIN_BINS - places[low], places[peak], places[high] + MARGIN_BINS

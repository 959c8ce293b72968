"""Where the search for a response begins: all frames laid over one another, shifted to their nominal arrivals."""

import numpy as np

from physics.arrivals import Arrivals

# Of the peak; the response begins and ends where the stack falls below this for good, or below its own noise.
FAINT = 2e-4
NOISE_SIGMAS = 4.0
MARGIN_BINS = 2.0


def stack(arrivals: Arrivals, counts: np.ndarray, alive: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Bins after the nominal arrival (B,), every quarter; light per frame there (B,); its standard error.

    Pedestals (the median of each histogram) are taken off; losses by dead time are made good. counts, alive: (F, P, T).
    """
    lattice, bins = arrivals.lattice, arrivals.bins
    light = arrivals.light
    knots = (lattice.first_s + lattice.step_s * np.arange(lattice.size)) / (lattice.step_s * lattice.per_bin)
    total = light.sum(axis=2)
    nominal = light @ knots / np.maximum(total, np.finfo(float).tiny)
    made_good = counts / np.maximum(alive, 0.02)
    pedestal = np.median(made_good, axis=2, keepdims=True)
    peak = (made_good - pedestal).max(axis=2)
    bright = (total > 0) & (peak > 0)
    place = np.arange(bins) + 0.5 - nominal[..., None]
    cell = np.round(place[bright] * 4).astype(int)
    low = int(cell.min())
    index, size = (cell - low).ravel(), int(cell.max()) - low + 1
    seen = np.maximum(np.bincount(index, minlength=size), 1)
    # Bright frames are given their weight: sums of counts over sums of levels.
    level = np.bincount(index, np.repeat(peak[bright], bins), size)
    sums = np.bincount(index, (made_good - pedestal)[bright].ravel(), size)
    noise = np.bincount(index, made_good[bright].ravel() / np.maximum(alive[bright].ravel(), 0.02), size)
    level = np.maximum(level, 1e-9)
    return (np.arange(size) + low) / 4, sums / level, np.sqrt(np.maximum(noise, seen)) / level


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

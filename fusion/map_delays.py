"""Delays of zones that nobody knows, one for each: profiled out of every comparison."""

import numpy as np

# By how much zones of such sensors differ, in order of magnitude.
SIGMA_S = 5e-11
# A delay is tried so many standard deviations earlier and later than the best, and found as far beyond by a parabola.
STEP, FARTHEST = 1.0, 2.0
# To find the best, so many standard deviations either way.
REACH = 4.0


def steps_bins(bin_width_s: float) -> np.ndarray:
    """(3,) delays that are tried about the best, in bins."""
    return np.array([-STEP, 0, STEP]) * SIGMA_S / bin_width_s


def sought_bins(bin_width_s: float) -> np.ndarray:
    """(L,) delays that are tried to find the best, in bins."""
    return np.arange(-REACH, REACH + STEP / 4, STEP / 2) * SIGMA_S / bin_width_s


def best_bins(score: np.ndarray, bin_width_s: float) -> np.ndarray:
    """(P,) most likely delays, in bins, from log-likelihoods (P, L) at those of `sought_bins`."""
    tried = sought_bins(bin_width_s)
    likely = score - _unlikely(tried, bin_width_s)
    at = np.clip(likely.argmax(axis=1), 1, len(tried) - 2)[:, None]
    before, here, after = (np.take_along_axis(likely, at + k, 1)[:, 0] for k in (-1, 0, 1))
    _, x = _top(before, here, after, 1.0)
    return tried[at[:, 0]] + x * (tried[1] - tried[0])


def profiled(score: np.ndarray, centre_bins: np.ndarray, bin_width_s: float) -> np.ndarray:
    """(P, C) log-likelihoods at the best delay, from those (P, C, 3) at `steps_bins` about the centres (P,)."""
    tried = centre_bins[:, None] + steps_bins(bin_width_s)
    likely = score - _unlikely(tried, bin_width_s)[:, None]
    return _top(*np.moveaxis(likely, -1, 0), FARTHEST)[0]


def _unlikely(bins: np.ndarray, bin_width_s: float) -> np.ndarray:
    """Minus the logarithm of the prior of delays, but for a constant."""
    return 0.5 * (bins * bin_width_s / SIGMA_S) ** 2


def _top(before: np.ndarray, here: np.ndarray, after: np.ndarray, farthest: float) -> tuple[np.ndarray, np.ndarray]:
    """Height and place, in steps from the middle, of the top of a parabola through three points; of the highest of
    them where it opens upwards."""
    slope, bend = (after - before) / 2, before - 2 * here + after
    x = np.where(bend < 0, np.clip(-slope / np.where(bend < 0, bend, 1), -farthest, farthest), np.sign(slope))
    x = np.where((bend >= 0) & (here >= np.maximum(before, after)), 0, x)
    return here + slope * x + bend * x**2 / 2, x

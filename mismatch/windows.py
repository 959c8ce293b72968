"""The window of zones, bins and frames whose counts are least likely: misfit that comes and goes in one place."""

from collections.abc import Iterator

import numpy as np
from scipy.stats import chi2, poisson

from mismatch.places import Place, told
from mismatch.poisson import LEAST
from mismatch.simulation import Simulation

# Frames and bins of windows; those between overlap enough with one of these.
LENGTHS = (1, 2, 4, 8, 16, 32, 64, 128)
# Windows whose sums are fewer standard deviations off are not looked at more closely.
LOOKED_AT = 3.5


def worst_window(simulation: Simulation, mean: np.ndarray) -> Place:
    """The window of one zone or all, by the tails of the Poisson law. mean: (F, P, T) expected counts.

    Its p-value is corrected for the number of windows, of all lengths in frames and in bins. A stray count where none
    is expected is no misfit: more than expected is judged beside `LEAST` in each cell.
    """
    alive = np.arange(mean.shape[1]) if simulation.dead is None else np.flatnonzero(~simulation.dead)
    sums = [_from_corner(a[:, alive]) for a in (simulation.counts, mean, np.maximum(mean, LEAST))]
    frames, bins = len(mean), mean.shape[2]
    tried, best, where = 0, 0.0, (0, frames, slice(None), 0, bins)
    for long in _lengths(frames):
        for wide in _lengths(bins):
            f, t = (np.arange(0, n - w + 1, max(w // 2, 1)) for n, w in ((frames, long), (bins, wide)))
            found, due, most = (_within(corner, f, long, t, wide) for corner in sums)
            tried += found.size
            far = np.flatnonzero(np.maximum(due - found, found - most) > LOOKED_AT * np.sqrt(np.maximum(due, LEAST)))
            if not len(far):
                continue
            n = found.flat[far]
            tails = np.minimum(poisson.logsf(n - 1, most.flat[far]), poisson.logcdf(n, due.flat[far]))
            if tails.min() < best:
                best = float(tails.min())
                i, p, j = np.unravel_index(far[int(np.argmin(tails))], found.shape)
                where = int(f[i]), long, slice(None) if p == len(alive) else slice(p, p + 1), int(t[j]), wide
    # There are two tails, but windows overlap by half, and are not as many as they seem.
    log_p = min(0.0, best + np.log(tried))
    first, long, zones, bin_, wide = where
    gain = float(chi2.isf(max(np.exp(log_p), 1e-300), 1))
    seen = tuple(int(z) for z in alive[zones])
    ends = (bin_, bin_ + wide - 1), (first, first + long - 1)
    return told(Place(seen, *ends, "nothing", 1.0, float(np.exp(log_p)), gain, ""))


def _lengths(most: int) -> Iterator[int]:
    """Lengths of windows up to the whole."""
    yield from (length for length in LENGTHS if length < most)
    yield most


def _from_corner(cells: np.ndarray) -> np.ndarray:
    """(F + 1, P + 1, T + 1) sums of (F, P, T) over all earlier frames and bins, of each zone and of all together."""
    every = np.concatenate([cells, cells.sum(axis=1, keepdims=True)], axis=1)
    return np.pad(every, ((1, 0), (0, 0), (1, 0))).cumsum(axis=0).cumsum(axis=2)


def _within(corner: np.ndarray, f: np.ndarray, long: int, t: np.ndarray, wide: int) -> np.ndarray:
    """(len(f), P + 1, len(t)) sums within windows that begin at these frames and bins."""
    rows = corner[f + long] - corner[f]
    return rows[..., t + wide] - rows[..., t]

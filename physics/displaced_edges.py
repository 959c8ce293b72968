"""Counts between edges of bins that are not where they should be."""

import numpy as np
from scipy.interpolate import PchipInterpolator

from physics.rendering import Rendering

# Part of the most counts by which a flat level may seem not to be.
ROUNDING = 1e-12


def counts_moved(counts: np.ndarray, late: np.ndarray, rendering: Rendering) -> np.ndarray:
    """(F, P, T) counts between edges that are so much later: (T + 1,) bins, or (P, T + 1) where zones have their own.

    The outermost stay, and one that would lie before the one before it lies there. Signal is read off its cumulative,
    which the arrivals give step by step of the pulse; all else is taken to be monotone cubic between the true edges.
    """
    even = np.arange(late.shape[-1] + 0.0)
    bins = even[-1]
    moved = even + late
    moved[..., 0] = 0
    moved = np.maximum.accumulate(np.minimum(moved, bins), axis=-1)
    moved[..., -1] = bins
    arrivals = getattr(rendering, "arrivals", None)
    rest, more = counts, 0.0
    if arrivals is not None:
        binned = arrivals.binned()
        rest = counts - rendering.gain * binned
        registered = arrivals.until(np.concatenate([moved, np.zeros_like(moved[..., :1])], axis=-1))
        even_so = registered[..., -1:] + np.cumsum(binned, axis=-1)
        more = rendering.gain * (registered[..., :-1] - np.concatenate([registered[..., -1:], even_so], axis=-1))
    if np.ptp(rest, axis=-1).max() <= ROUNDING * counts.max():
        more = more + rest.mean(axis=-1, keepdims=True) * (moved - even)
    else:
        until = np.concatenate([np.zeros_like(rest[..., :1]), np.cumsum(rest, axis=-1)], axis=-1)
        more = more + _read(until, moved) - until
    # Where there are no counts, rounding alone could bring a bin below 0.
    return np.maximum(counts + np.diff(more, axis=-1), 0)


def _read(until: np.ndarray, moved: np.ndarray) -> np.ndarray:
    """A cumulative (..., T + 1) at edges (T + 1,), or at those of each zone."""
    even = np.arange(until.shape[-1])
    if moved.ndim == 1:
        return PchipInterpolator(even, until, axis=-1)(moved)
    each = [PchipInterpolator(even, until[..., p, :], axis=-1)(moved[p]) for p in range(len(moved))]
    return np.stack(each, axis=-2)

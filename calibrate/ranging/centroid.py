"""The mean arrival of the bins about the highest one."""

import numpy as np

from calibrate.impulse.likelihood import exposure
from recordings.refusal import Refusal


def centroid_bins(
    counts: np.ndarray, before: int = 2, after: int = 2, shots: np.ndarray | float | None = None
) -> np.ndarray:
    """(...) centre of counts (..., T) in bins, from `before` bins before the highest one to `after` bins after it.

    Bin t is at t. The median of each histogram is taken off as its pedestal. shots: laser shots, one number: losses to
    earlier photons are made good first (Coates 1968, J. Phys. E 1, 878). NaN where nothing rises above the pedestal.
    """
    counts = np.asarray(counts, float)
    bins = counts.shape[-1]
    if min(before, after) < 0 or before + after >= bins:
        raise Refusal(f"a centroid of {before} bins before and {after} after the peak, expected fewer than {bins}")
    rows = counts.reshape(1, -1, bins)
    if shots is not None:
        share = rows / (shots * exposure(rows, np.array([float(shots)])))
        rows = -shots * np.log1p(-np.minimum(share, 1 - 1e-9))
    rows = rows[0]
    peak = rows.argmax(axis=1)
    place = peak[:, None] + np.arange(-before, after + 1)
    inside = (place >= 0) & (place < bins)
    near = np.take_along_axis(rows, np.clip(place, 0, bins - 1), axis=1)
    weight = np.where(inside, near - np.median(rows, axis=1, keepdims=True), 0)
    total = weight.sum(axis=1)
    centre = (weight * place).sum(axis=1) / np.where(total > 0, total, np.nan)
    return centre.reshape(counts.shape[:-1])

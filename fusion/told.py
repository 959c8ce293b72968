"""What a moving camera and the zones tell of each pixel's range together."""

import numpy as np
from numba import njit
from scipy.ndimage import gaussian_filter1d

from fusion.motion import FINER, Motion, finer, grey
from fusion.shares import STEP, Shares
from fusion.sight import Sight, rescaled
from fusion.sweep import plane_sweep

# Depths that are tried, evenly in the logarithm, from the nearest to the farthest that any zone reports.
DEPTHS = 24
# Zones blur by this much of the logarithm of range; and surfaces that they do not report are this likely beside them.
BLUR, ELSEWHERE = 2 * STEP, 0.05
# Pixels where no zone responds with this part of its peak are left out, and of others zones with less than this share.
UNHEARD, FAINT = 0.01, 0.03
# Part of a zone's view that does not count as reported.
UNREPORTED = 0.001
# Standard deviation of the logarithm of range that poses and windows leave, and from which on nothing is told.
LEAST_SIGMA, MOST_SIGMA = 0.05, 0.3


def told(grid: Sight, observed: Shares, rgb: np.ndarray, motion: Motion) -> tuple[np.ndarray, np.ndarray]:
    """Logarithm of range (metres) and its precision, both (h, w) on the coarse `grid`; precision 0 where none is told.

    observed: what the zones report. rgb: (H, W, 3) uint8, the present image. The probability of a depth is the
    product of how well it explains both images (`plane_sweep`) and of what the zones that see the pixel report, each
    as far as it is heard there; mean and variance of it are returned.
    """
    heard = grid.normalised[observed.zones].astype(float)
    mean, variance = np.zeros(grid.shape), np.full(grid.shape, np.inf)
    rows, columns = (_span((heard > UNHEARD).any(axis=(0, axis))) for axis in (2, 1))
    nearest, farthest = _ends(observed)
    depth_m = np.geomspace(nearest / grid.ray_length.max(), farthest, DEPTHS)
    # Of the present image only what zones see.
    now = grey(rgb, finer(grid.shape))[
        FINER * rows.start : FINER * rows.stop, FINER * columns.start : FINER * columns.stop
    ]
    whole = rescaled(grid.intrinsics, FINER, FINER)
    part = np.array([[1, 0, -FINER * columns.start], [0, 1, -FINER * rows.start], [0, 0, 1]]) @ whole
    found = plane_sweep(now, motion.grey, (part, whole), motion.step, depth_m)
    likelihood = sum(found[:, i::FINER, k::FINER] for i in range(FINER) for k in range(FINER)) / np.float32(FINER**2)
    share = (heard / np.maximum(heard.sum(axis=0), 1e-12))[:, rows, columns]
    share[share < FAINT] = 0
    density = gaussian_filter1d(np.gradient(observed.cumulative, STEP, axis=1), BLUR / STEP, axis=1)
    lengths = np.log(grid.ray_length[rows, columns].astype(float))
    mean[rows, columns], variance[rows, columns] = _moments(
        likelihood, np.log(depth_m), lengths, np.ascontiguousarray(share), density, observed.log_m[0], STEP
    )
    known = variance < MOST_SIGMA**2
    return np.where(known, mean, 0.0), np.where(known, 1 / (variance + LEAST_SIGMA**2), 0.0)


def _span(there: np.ndarray) -> slice:
    """From the first that is to the last."""
    return slice(int(there.argmax()), len(there) - int(there[::-1].argmax()))


def _ends(observed: Shares) -> tuple[float, float]:
    """The nearest and the farthest range that any zone reports, metres, and a tenth beyond."""
    begun = (observed.cumulative > UNREPORTED).any(axis=0).argmax()
    over = len(observed.log_m) - 1 - (observed.cumulative < 1 - UNREPORTED).any(axis=0)[::-1].argmax()
    first, last = np.exp(observed.log_m[[min(begun, over), max(begun, over)]])
    return first / 1.1, last * 1.1


@njit(nogil=True, cache=True)
def _moments(likelihood, log_depth, log_length, share, density, first, step):
    """(h, w) mean and variance of the logarithm of range; variance infinite where a depth is not shown or heard."""
    depths, height, width = likelihood.shape
    mean, variance = np.zeros((height, width)), np.full((height, width), np.inf)
    heights = np.empty(depths)
    for v in range(height):
        for u in range(width):
            most = -np.inf
            for k in range(depths):
                place = (log_depth[k] + log_length[v, u] - first) / step
                b = min(max(int(place), 0), density.shape[1] - 2)
                part = min(max(place - b, 0.0), 1.0)
                here = 0.0
                for p in range(len(share)):
                    if share[p, v, u] > 0:
                        here += share[p, v, u] * (density[p, b] * (1 - part) + density[p, b + 1] * part)
                heights[k] = likelihood[k, v, u] + np.log(here + ELSEWHERE)
                most = max(most, heights[k])
            if not np.isfinite(heights.sum()):
                continue
            total = middle = square = 0.0
            for k in range(depths):
                weight = np.exp(heights[k] - most)
                total += weight
                middle += weight * log_depth[k]
                square += weight * log_depth[k] ** 2
            mean[v, u] = middle / total + log_length[v, u]
            variance[v, u] = max(square / total - (middle / total) ** 2, 0.0)
    return mean, variance

"""How much samples of a scan scatter around what their neighbours say."""

import numpy as np
from scipy.optimize import isotonic_regression
from scipy.spatial import cKDTree

NEIGHBOURS = 20
LEAST_CLASS = 40  # samples of about one brightness, of which the scatter is taken
MOST_CLASSES = 20
ONE_SIGMA = 0.6827


def local_scatter(xy: np.ndarray, values: np.ndarray) -> np.ndarray:
    """(P, K) standard deviation of one sample, from P maps (P, K) at (K, 2) pixels.

    Each sample is predicted by a quadratic surface through its neighbours without it; the 68 % quantile of the error,
    freed of the prediction's own, is taken over samples of like brightness. Structure finer than that counts as noise.
    """
    near = cKDTree(xy).query(xy, min(NEIGHBOURS + 1, len(xy)))[1][:, 1:]
    step = xy[near] - xy[:, None]
    u, v = np.moveaxis(step / np.abs(step).max(), -1, 0)
    surface = np.stack([np.ones_like(u), u, v, u * u, u * v, v * v], axis=2)
    weights = np.linalg.pinv(surface)[:, 0]
    predicted = np.einsum("kn,pkn->pk", weights, values[:, near])
    error = (values - predicted) / np.sqrt(1 + (weights**2).sum(axis=1))
    return np.stack([_by_brightness(p, e) for p, e in zip(predicted, error, strict=True)])


def _by_brightness(level: np.ndarray, error: np.ndarray) -> np.ndarray:
    """(K,) scatter as a non-decreasing function of the level; the bright, few but what matters, in classes as fine."""
    order = np.argsort(level)
    bright = len(order) - len(order) // 8
    classes = [
        part
        for half in (order[:bright], order[bright:])
        for part in np.array_split(half, min(max(len(half) // LEAST_CLASS, 1), MOST_CLASSES))
    ]
    at = np.array([np.median(level[c]) for c in classes])
    spread = np.array([np.quantile(np.abs(error[c]), ONE_SIGMA) for c in classes])
    return np.interp(level, at, isotonic_regression(spread).x)

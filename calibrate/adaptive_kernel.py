"""How far maps depart from the model of the optics, what a sample's error is, and the algebra of Gaussian processes."""

import numpy as np
from scipy.linalg import solve_triangular
from scipy.spatial.distance import cdist

from calibrate.adaptive_model import Rows
from calibrate.banded import one_thread

REACH = 1.2  # correlation length of departures, patch radii
RELATIVE, FLOOR = 0.01, 0.004  # a zone's error at a sample besides its own: relative, and as a share of its peak
# To begin with: departures in the flood's texture, common to the zones, and in each zone; errors that the zones of one
# sample share, of its brightness, and of its place, patch radii.
STRENGTHS = (0.1, 0.03, 0.02, 0.03)
# Free to grow, the flood's texture takes the place of the optics as long as samples are few: a second optimum, in which
# errors are overstated wherever it is bright, and light scattered nearby comes out negative.
LEAST, MOST = (0.01, 0.01, 0.002, 0.003), (0.12, 0.5, 0.1, 0.2)
DOUBT = (0.4, 0.4, 0.7, 0.7)  # of their logarithms: a few samples tell little of them


def alone_noise(value: np.ndarray, seen: np.ndarray, sigma: np.ndarray) -> np.ndarray:
    """(N,) variances of what each response has for itself."""
    return sigma**2 + (RELATIVE * np.maximum(value, seen)) ** 2 + FLOOR**2


def shared(rows: Rows, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """(N, N) twice: errors that the zones of one sample share, its brightness being off, and its place."""
    same = rows.cell[:, None] == rows.cell
    bright = np.minimum(rows.value, 1)
    return same * np.outer(bright, bright), same * (rows.tilt @ rows.tilt.T) * radius**2


def departures(a: Rows, b: Rows, xy_a: np.ndarray, xy_b: np.ndarray, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """(Na, Nb) twice, covariance of departures: texture of the flood, which zones share, and what each has alone."""
    alike = matern(cdist(xy_a, xy_b) / reach)[a.cell[:, None], b.cell]
    # Beyond the peak there is nothing to depart from: what is modelled brighter must not buy itself freedom.
    texture = np.minimum(a.value, 1)[:, None] * np.minimum(b.value, 1)
    # Where little light is expected, what is not modelled is a larger part of it: variances go with the brightness.
    own = np.sqrt(np.outer(np.clip(a.near, 0, 1), np.clip(b.near, 0, 1))) * (a.zone[:, None] == b.zone)
    return alike * texture, alike * own


def matern(distance: np.ndarray) -> np.ndarray:
    """Matérn's correlation, smoothness 3/2, of distances in correlation lengths."""
    return (1 + np.sqrt(3) * distance) * np.exp(-np.sqrt(3) * distance)


def solved(covariance: np.ndarray, residual: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """Cholesky factor, the inverse times the residual, and the logarithm of the evidence."""
    with one_thread():
        factor = np.linalg.cholesky(covariance)
        half = solve_triangular(factor, residual, lower=True, check_finite=False)
        pull = solve_triangular(factor, half, lower=True, trans=1, check_finite=False)
    return factor, pull, float(-0.5 * half @ half - np.log(np.diag(factor)).sum())

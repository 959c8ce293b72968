"""How far maps depart from the model of the optics, what a sample's error is, and the algebra of Gaussian processes."""

import numpy as np
from scipy.linalg import solve_triangular
from scipy.spatial.distance import cdist

from calibrate.adaptive_model import Rows
from calibrate.banded import one_thread

REACH = 1.2  # correlation length of departures, patch radii
RELATIVE, FLOOR = 0.01, 0.004  # a sample's error besides its own: relative, and as a share of the zone's peak


def noise(rows: Rows, seen: np.ndarray, sigma: np.ndarray) -> np.ndarray:
    """(N,) variances of the samples (P, n) in `rows`, given their own standard errors."""
    own = sigma[rows.zone, rows.cell] ** 2
    return own + (RELATIVE * np.maximum(rows.value, seen[rows.zone, rows.cell])) ** 2 + FLOOR**2


def departures(a: Rows, b: Rows, xy_a: np.ndarray, xy_b: np.ndarray, strengths: tuple, reach: float) -> np.ndarray:
    """(Na, Nb) covariance of departures: texture of the flood, common to all zones, and what each zone has alone."""
    alike = matern(cdist(xy_a, xy_b) / reach)[a.cell[:, None], b.cell]
    # Beyond the peak there is nothing to depart from: what is modelled brighter must not buy itself freedom.
    texture = strengths[0] ** 2 * np.minimum(a.value, 1)[:, None] * np.minimum(b.value, 1)
    own = strengths[1] ** 2 * np.minimum(a.near, 1)[:, None] * np.minimum(b.near, 1) * (a.zone[:, None] == b.zone)
    return alike * (texture + own)


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

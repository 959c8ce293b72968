"""Area-to-point kriging: the smoothest image whose means over footprints are those that were measured."""

import numpy as np

from fusion.edges import Field


def krige(field: Field, footprints: np.ndarray, means: np.ndarray, noise: float) -> np.ndarray:
    """(H, W) best linear unbiased image, from its means (Q,) over footprints (Q, H, W) that sum to 1 each.

    Ordinary area-to-point kriging with the field's covariance A⁻¹ and an unknown constant (Kyriakidis 2004, A
    geostatistical framework for area-to-point spatial interpolation, Geographical Analysis 36). noise: standard
    deviation of what the means are off, as part of the standard deviation that the field gives them.
    """
    spread, between = _covariances(field, footprints)
    between[np.diag_indices_from(between)] += noise**2 * np.trace(between) / len(between)
    both = np.linalg.solve(between, np.stack([means, np.ones_like(means)], axis=1))
    constant = both[:, 0].sum() / both[:, 1].sum()
    return constant + np.tensordot(both[:, 0] - constant * both[:, 1], spread, axes=1)


def krige_about(field: Field, footprints: np.ndarray, means: np.ndarray, sigma: float, about: np.ndarray) -> np.ndarray:
    """The same of a field that varies about an image (H, W) with covariance A⁻¹: no constant is unknown.

    sigma: standard deviation of what the means are off.
    """
    spread, between = _covariances(field, footprints)
    between[np.diag_indices_from(between)] += sigma**2
    off = means - np.tensordot(footprints, about, axes=2)
    return about + np.tensordot(np.linalg.solve(between, off), spread, axes=1)


def _covariances(field: Field, footprints: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(Q, H, W) of means with pixels, and (Q, Q) of means with each other."""
    spread = field.solve(footprints)
    between = footprints.reshape(len(footprints), -1) @ spread.reshape(len(spread), -1).T
    return spread, (between + between.T) / 2

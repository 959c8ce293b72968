"""The smoothest image of range that agrees with the zones' means, and with what images of a moving camera tell."""

from dataclasses import replace

import numpy as np

from fusion.edges import Field
from fusion.kriging import krige, krige_about
from fusion.matching import ranks
from fusion.prior import Prior
from fusion.shares import STEP, Shares

Points = tuple[np.ndarray, np.ndarray]


def smoothest(
    field: Field, footprints: np.ndarray, observed: Shares, points: Points | None, prior: Prior
) -> tuple[np.ndarray, np.ndarray | float]:
    """(H, W) logarithm of range, and how firmly each pixel is held there, in units of the field's weights.

    footprints: (Q, H, W) that sum to 1 each. points: logarithm of range and its precision at each pixel, (H, W), as
    images tell it. Where a pose is wrong, something moved, or only outlines are told, which may belong to either side,
    points and field make an image that has not the zones' histograms. They are believed where that image, without the
    zones' means, is no farther from them than the image of these means alone by `prior.agree`.
    """
    alone = krige(field, footprints, observed.mean, prior.mean_off)
    if points is None or not points[1].any():
        return alone, 0.0
    value, precision = points
    # In units of a step on one surface, which is what the field's weights are in.
    firm, middle = precision * prior.smooth**2, observed.mean.mean()
    held = replace(field, ridge=field.ridge + firm)
    about = middle + held.solve(firm * (value - middle))
    if departure(about, footprints, observed) > prior.agree * departure(alone, footprints, observed):
        return alone, 0.0
    return krige_about(held, footprints, observed.mean, prior.mean_sigma / prior.smooth, about), firm


def departure(image: np.ndarray, footprints: np.ndarray, observed: Shares) -> float:
    """Cramér distance ∫(F - F°)² dx of the image in each zone from what was observed there, the mean over zones."""
    values, bins, first = np.ascontiguousarray(image.ravel(), float), len(observed.log_m), observed.log_m[0]
    parts = [ranks(values, np.ascontiguousarray(one.ravel()), bins, first, STEP) for one in footprints]
    return float(np.square(np.stack(parts) - observed.cumulative).sum() * STEP / len(footprints))

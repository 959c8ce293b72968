"""Readings of a sensor become metres: a line or a curve for each zone, or lines and one curve that all zones share."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline

from recordings.refusal import Refusal

LINES, SHARED, CURVES = "a line per zone", "a line per zone, one curve for all", "a curve per zone"
# Powers of the shared curve: what bends by one arc or an S, whatever its lines.
POWERS = (2, 3)
# Pieces of a zone's own curve, a cubic spline; each holds as many of the readings it is fitted to.
PIECES = 4


@dataclass(frozen=True, eq=False)
class Straightened:
    """What readings (F, P) are in metres.

    metres: (F, P). parameters: how many numbers were fitted.
    """

    metres: np.ndarray
    parameters: int


def straighten(readings: np.ndarray, metres: np.ndarray, fitted: np.ndarray, freedom: str = LINES) -> Straightened:
    """Metres for all readings (F, P), by least squares on those frames where `fitted` (F,) is true.

    metres: (F,) true distances; only those of fitted frames are looked at. freedom: LINES, SHARED or CURVES.
    """
    readings, metres, fitted = np.asarray(readings, float), np.asarray(metres, float), np.asarray(fitted, bool)
    if readings.ndim != 2 or metres.shape != readings.shape[:1] or fitted.shape != metres.shape:
        found = f"{readings.shape}, {metres.shape} and {fitted.shape}"
        raise Refusal(f"readings, metres and fitted frames have shapes {found}, expected (F, P), (F,) and (F,)")
    if not np.isfinite(readings).all() or not np.isfinite(metres[fitted]).all():
        raise Refusal("readings or true distances hold NaN or infinity, expected numbers")
    if freedom not in (LINES, SHARED, CURVES):
        raise Refusal(f"freedom is {freedom!r}, expected one of {LINES!r}, {SHARED!r}, {CURVES!r}")
    zones = readings.shape[1]
    own = [_curve(r, fitted) if freedom == CURVES else np.stack([np.ones_like(r), r], axis=1) for r in readings.T]
    widths = [block.shape[1] for block in own]
    shared = len(POWERS) if freedom == SHARED else 0
    design = np.zeros((len(readings), zones, sum(widths) + shared))
    for zone, block in enumerate(own):
        first = sum(widths[:zone])
        design[:, zone, first : first + widths[zone]] = block
    if shared:
        middle, reach = readings[fitted].mean(), readings[fitted].std()
        design[:, :, -shared:] = ((readings - middle) / reach)[..., None] ** np.array(POWERS)
    size = design.shape[2]
    if fitted.sum() * zones < size:
        raise Refusal(f"{int(fitted.sum())} frames are to fit {size} numbers for {zones} zones, expected more frames")
    answer = np.repeat(metres[fitted], zones)
    found, *_ = np.linalg.lstsq(design[fitted].reshape(-1, size), answer, rcond=None)
    return Straightened(design @ found, size)


def _curve(readings: np.ndarray, fitted: np.ndarray) -> np.ndarray:
    """(F, K) cubic B-splines of one zone's readings, their end pieces carried on beyond those that are fitted."""
    inner = np.quantile(readings[fitted], np.arange(1, PIECES) / PIECES)
    low, high = readings[fitted].min(), readings[fitted].max()
    knots = np.concatenate([[low] * 4, inner, [high] * 4])
    return BSpline(knots, np.eye(len(knots) - 4), 3, extrapolate=True)(readings)

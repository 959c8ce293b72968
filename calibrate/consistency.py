"""How well two calibrations of one sensor agree: overlap, displacement and cosine of their maps, zone by zone."""

from dataclasses import dataclass

import numpy as np

from recordings.maps import ResponseMaps
from recordings.refusal import Refusal

THRESHOLD = 0.1
SAME_POSITION_PX = 0.5


@dataclass(frozen=True)
class Consistency:
    """Agreement of two peak-normalised calibrations, per zone.

    iou: (P,) intersection over union of the supports at `threshold` of each zone's peak.
    displacement_px: (P,) distance between the response-weighted centroids.
    cosine: (P,) cosine between the peak-normalised maps as vectors over scan positions.
    threshold: fraction of the peak that bounds a support.
    positions: number of scan positions compared.
    """

    iou: np.ndarray
    displacement_px: np.ndarray
    cosine: np.ndarray
    threshold: float
    positions: int

    def summary(self) -> dict[str, tuple[float, float]]:
        """Mean and standard deviation over the zones (of the population, as published) of each figure."""
        figures = {"iou": self.iou, "displacement_px": self.displacement_px, "cosine": self.cosine}
        return {name: (float(value.mean()), float(value.std())) for name, value in figures.items()}


def compare(a: ResponseMaps, b: ResponseMaps, threshold: float = THRESHOLD) -> Consistency:
    """Compare two calibrations at the scan positions they share (Behari & Raskar 2026, consistency of modes).

    Raises `Refusal` where the zones differ, the positions differ, or a zone never responds.
    """
    if not 0 < threshold < 1:
        raise Refusal(f"threshold: {threshold} found, expected a fraction of the peak between 0 and 1")
    first, second = common_positions(a, b)
    xy = np.stack([a.xs, a.ys], axis=1)[first].astype(float)
    map_a, map_b = _peak_normalised(a, first, "first"), _peak_normalised(b, second, "second")
    shift = centroids(map_a, xy) - centroids(map_b, xy)
    return Consistency(
        iou=support_iou(map_a, map_b, threshold),
        displacement_px=np.hypot(shift[:, 0], shift[:, 1]),
        cosine=cosines(map_a, map_b),
        threshold=threshold,
        positions=len(first),
    )


def common_positions(a: ResponseMaps, b: ResponseMaps) -> tuple[np.ndarray, np.ndarray]:
    """Indices into `a` and into `b` of the captures both have, matched by capture id.

    Two calibrations may each have left out captures in which no patch was seen.
    """
    if a.zone_grid != b.zone_grid:
        raise Refusal(f"zones: {a.zone_grid} in the first and {b.zone_grid} in the second, expected the same grid")
    if a.image_size != b.image_size:
        raise Refusal(f"image size: {a.image_size} and {b.image_size}, expected the same camera image")
    _, first, second = np.intersect1d(a.cap_ids, b.cap_ids, return_indices=True)
    order = np.argsort(first)
    first, second = first[order], second[order]
    if len(first) < 3:
        raise Refusal(f"cap_ids: {len(first)} captures are in both calibrations, expected at least 3")
    apart = np.hypot(a.xs[first] - b.xs[second], a.ys[first] - b.ys[second])
    if np.median(apart) > SAME_POSITION_PX:
        raise Refusal(
            f"xs, ys: captures of the same id lie {np.median(apart):.1f} px apart (median), expected the two "
            f"calibrations to share their scan positions within {SAME_POSITION_PX} px"
        )
    return first, second


def _peak_normalised(maps: ResponseMaps, captures: np.ndarray, which: str) -> np.ndarray:
    values = maps.by_zone[:, captures].astype(float)
    peaks = values.max(axis=1)
    if dead := np.flatnonzero(peaks <= 0).tolist():
        raise Refusal(f"responses: zones {dead} of the {which} calibration never respond, expected a peak above 0")
    return values / peaks[:, None]


def support_iou(map_a: np.ndarray, map_b: np.ndarray, threshold: float) -> np.ndarray:
    """(P,) intersection over union of where two (P, K) peak-normalised maps reach `threshold`; 1 where neither does."""
    in_a, in_b = map_a >= threshold, map_b >= threshold
    union = (in_a | in_b).sum(axis=1)
    return np.where(union > 0, (in_a & in_b).sum(axis=1) / np.maximum(union, 1), 1.0)


def centroids(maps: np.ndarray, xy: np.ndarray) -> np.ndarray:
    """(P, 2) response-weighted mean position, pixels, of (P, K) maps sampled at `xy` (K, 2)."""
    return maps @ xy / maps.sum(axis=1, keepdims=True)


def cosines(map_a: np.ndarray, map_b: np.ndarray) -> np.ndarray:
    """(P,) cosine between (P, K) maps as vectors over scan positions."""
    norms = np.linalg.norm(map_a, axis=1) * np.linalg.norm(map_b, axis=1)
    return (map_a * map_b).sum(axis=1) / norms


def iou_curve(a: ResponseMaps, b: ResponseMaps, thresholds: np.ndarray) -> np.ndarray:
    """(len(thresholds), P) intersection over union at every threshold, not only the one that flatters."""
    return np.stack([compare(a, b, float(threshold)).iou for threshold in thresholds])

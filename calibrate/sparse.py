"""What a shorter scan costs: maps predicted from fewer positions, compared with the full map."""

from dataclasses import dataclass

import numpy as np

from calibrate.consistency import THRESHOLD, cosines, support_iou
from calibrate.kernel import fit_kernel
from recordings.maps import ResponseMaps
from recordings.progress import Progress, silent
from recordings.refusal import Refusal

POINTS = (1800, 900, 450, 225)


@dataclass(frozen=True)
class SparseScan:
    """How maps predicted from `points` positions agree with the full scan at all of its positions, per zone.

    cosine, iou: (P,). left_out_cosine: (P,) the same at the positions that took no part in the prediction.
    """

    points: int
    cosine: np.ndarray
    iou: np.ndarray
    left_out_cosine: np.ndarray


def sparse_scans(
    maps: ResponseMaps,
    patch_radius_px: float,
    points: tuple[int, ...] = POINTS,
    threshold: float = THRESHOLD,
    progress: Progress = silent,
) -> list[SparseScan]:
    """Predict the full map from ever fewer of its positions; the first to go are those with the closest neighbours."""
    total = len(maps.xs)
    if wrong := [n for n in points if not 10 <= n <= total]:
        raise Refusal(f"points: {wrong[0]} found, expected 10 to {total}, the positions of the full scan")
    x, y = maps.xs.astype(float), maps.ys.astype(float)
    order = spread_order(np.stack([x, y], axis=1), max(points))
    full = maps.normalised
    found = []
    for n in progress(points, len(points), "fewer scan points"):
        kernel = fit_kernel(maps, patch_radius_px, np.sort(order[:n]))
        predicted = kernel.response(x, y)
        predicted /= predicted.max(axis=1, keepdims=True)
        left_out = np.setdiff1d(np.arange(total), order[:n])
        unseen = left_out if len(left_out) else np.arange(total)
        found.append(
            SparseScan(
                points=n,
                cosine=cosines(full, predicted),
                iou=support_iou(full, predicted, threshold),
                left_out_cosine=cosines(full[:, unseen], predicted[:, unseen]),
            )
        )
    return found


def spread_order(xy: np.ndarray, count: int) -> np.ndarray:
    """(count,) indices into `xy` (N, 2), each the point farthest from all before it (Gonzalez 1985).

    Every beginning of the order covers the field evenly. It starts at the point nearest the middle.
    """
    order = np.empty(count, int)
    order[0] = np.square(xy - xy.mean(axis=0)).sum(axis=1).argmin()
    nearest = np.full(len(xy), np.inf)
    for i in range(1, count):
        np.minimum(nearest, np.square(xy - xy[order[i - 1]]).sum(axis=1), out=nearest)
        order[i] = nearest.argmax()
    return order

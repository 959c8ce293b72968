"""Depth images from nine ranges, as one would make them without unmixing."""

import cv2
import numpy as np
from scipy.interpolate import RegularGridInterpolator

from fusion.sight import Sight

# TMF8828, map 6 (3 × 3 wide): field of view of the datasheet (DS000693), across and down, in zones of equal size.
FIELD_DEG = (41.0, 52.0)
# Guided filter (He, Sun & Tang 2013): radius as part of the image's width, and the variance of grey that is no edge.
RADIUS, FLAT = 1 / 16, 1e-3


def alternatives(sight: Sight, range_m: np.ndarray, rgb: np.ndarray) -> dict[str, np.ndarray]:
    """(H, W) depth in metres of each alternative, by its name, from one range (P,) for each zone.

    Zones are where their maps' centroids are, so that each alternative has the right orientation. A zone without a
    range (NaN) has that of the nearest that has one.
    """
    columns, rows, table = _layout(sight)
    v, u = np.mgrid[: sight.shape[0], : sight.shape[1]].astype(float)
    centres = np.stack(_centres(sight), axis=1)
    known = np.flatnonzero(np.isfinite(range_m))
    filled = np.array([range_m[known[np.argmin(np.square(centres[known] - c).sum(axis=1))]] for c in centres])
    grid = filled[table]
    nearest = filled[np.argmin([(u - x) ** 2 + (v - y) ** 2 for x, y in centres], axis=0)]
    inside = np.stack([np.clip(v, rows[0], rows[-1]), np.clip(u, columns[0], columns[-1])], axis=-1)
    bilinear = RegularGridInterpolator((rows, columns), grid)(inside) / sight.ray_length
    return {
        "nearest zone": nearest / sight.ray_length,
        "datasheet rectangles": grid[_rectangles(sight, columns, rows)] / sight.ray_length,
        "bilinear": bilinear,
        "guided filter": guided_filter(bilinear, rgb),
    }


def guided_filter(image: np.ndarray, rgb: np.ndarray) -> np.ndarray:
    """(H, W) image, locally linear in the grey of `rgb` (He, Sun & Tang 2013, Eq. 5, 6 and 8)."""
    grey = cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY) / 255.0
    size = 2 * max(1, round(RADIUS * image.shape[1])) + 1

    def mean(a: np.ndarray) -> np.ndarray:
        return cv2.blur(a, (size, size))

    slope = (mean(grey * image) - mean(grey) * mean(image)) / (mean(grey**2) - mean(grey) ** 2 + FLAT)
    return mean(slope) * grey + mean(mean(image) - slope * mean(grey))


def _centres(sight: Sight) -> tuple[np.ndarray, np.ndarray]:
    """(P,) x and (P,) y of the centroids of the maps."""
    v, u = np.mgrid[: sight.shape[0], : sight.shape[1]]
    total = sight.weights.sum(axis=(1, 2), dtype=float)
    return tuple((sight.weights * a).sum(axis=(1, 2), dtype=float) / total for a in (u, v))


def _layout(sight: Sight) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Ascending x of the columns and y of the rows of zones in the image, and which zone (rows, columns) is there."""
    x, y = (c.reshape(sight.zone_grid) for c in _centres(sight))
    across, down = x.mean(axis=0), y.mean(axis=1)
    column, row = np.argsort(across), np.argsort(down)
    return across[column], down[row], np.arange(sight.zones).reshape(sight.zone_grid)[np.ix_(row, column)]


def _rectangles(sight: Sight, columns: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Row and column of the rectangle at each pixel, (H, 1) and (1, W); the outer ones go on to the image's border."""
    places = []
    for axis, centres in ((1, rows), (0, columns)):
        reach = np.tan(np.radians(FIELD_DEG[axis] / 2)) * sight.intrinsics[axis, axis]
        borders = centres.mean() + np.linspace(-reach, reach, len(centres) + 1)[1:-1]
        places.append(np.searchsorted(borders, np.arange(sight.shape[1 - axis])))
    return places[0][:, None], places[1][None]

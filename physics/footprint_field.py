"""Response maps at any point of the image, as the exchange format reads them, and as a fit that moves them needs."""

import threading
from collections.abc import Callable
from functools import cached_property

import numpy as np
from numba import njit
from scipy.interpolate import LinearNDInterpolator
from scipy.spatial import Delaunay, QhullError

from recordings.maps import ResponseMaps
from recordings.refusal import Refusal

# Beyond the hull maps are 0; moved ones fall to it over this part of the mean spacing of the scan, for continuity. Not
# over more: where lobes are cut by it a tenth made 7 mm between sensor and camera 4.
REACH = 0.03
# What changes of the table add is kept for so many, as fits come back to where they were.
KEPT = 6


class FootprintField:
    """Responses of P zones at any point of the full-size image, counts.

    Linear on the Delaunay triangles of the scan points, 0 outside their hull. Call with x, y (...) in pixels of the
    full-size image: (P, ...). full_size: width, height. reach_px: how far beyond the hull `faded` goes, the mean
    spacing of the scan. first: x, y of the table's first entry, pixels.
    """

    def __init__(self, maps: ResponseMaps) -> None:
        self.full_size = maps.image_size
        self._added: dict[tuple, np.ndarray] = {}
        self._adding = threading.Lock()
        points = np.stack([maps.xs, maps.ys], axis=1).astype(float)
        try:
            triangles = Delaunay(points)
        except (QhullError, ValueError):
            raise Refusal(
                f"response maps: {len(points)} scan points span no triangle, expected points off one line"
            ) from None
        self._interpolate = LinearNDInterpolator(triangles, maps.by_zone.T.astype(float), fill_value=np.nan)
        self._of_zone = [LinearNDInterpolator(triangles, zone[:, None].astype(float)) for zone in maps.by_zone]
        edges = triangles.convex_hull
        self._ends, self._responses = (np.ascontiguousarray(a[edges], float) for a in (points, maps.by_zone.T))
        corners = points[triangles.simplices]
        area = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])).sum() / 2
        self.reach_px = REACH * float(np.sqrt(area / len(points)))
        # The image and the scan, which may go beyond it; not farther than a whole image on any side.
        size = np.array(self.full_size)
        low = np.clip(np.floor(points.min(axis=0)), -size, 0).astype(int)
        high = np.clip(np.ceil(points.max(axis=0)), size - 1, 2 * size - 1).astype(int)
        self.first, self._shape = (int(low[0]), int(low[1])), tuple(high[::-1] - low[::-1] + 1)

    @property
    def pixels(self) -> int:
        """How many the table has, those of all zones."""
        return self._responses.shape[-1] * self._shape[0] * self._shape[1]

    def __call__(self, x_px: np.ndarray, y_px: np.ndarray) -> np.ndarray:
        """(P, ...) responses at image points."""
        read = self._interpolate(x_px, y_px)
        return np.moveaxis(np.where(np.isnan(read), 0, read), -1, 0)

    def faded(self, x_px: np.ndarray, y_px: np.ndarray, zone: int | None = None) -> np.ndarray:
        """(P, ...) the same without the jump at the hull: beyond, those of its nearest point fall to 0 over the reach.

        What moves across a jump has no derivative, and nothing of what was measured is one. zone: (1, ...) of it alone.
        """
        interpolate = self._interpolate if zone is None else self._of_zone[zone]
        responses = self._responses if zone is None else self._responses[..., zone : zone + 1]
        read = interpolate(x_px, y_px)
        outside = np.isnan(read[..., 0])
        x, y = (np.broadcast_to(a, outside.shape)[outside].astype(float) for a in (x_px, y_px))
        read[outside] = _beyond(x, y, self._ends, responses, self.reach_px)
        return np.moveaxis(read, -1, 0)

    @cached_property
    def table(self) -> np.ndarray:
        """(P, Y, X) float32 faded responses at whole pixels from `first` on: the image, and the scan."""
        rows, columns = self._shape
        x = self.first[0] + np.arange(columns, dtype=float)
        made = [self.faded(x, np.full(columns, self.first[1] + row)).astype(np.float32) for row in range(rows)]
        return np.stack(made, axis=1)

    def added(self, drawings: tuple[Callable[[np.ndarray], np.ndarray], ...]) -> np.ndarray:
        """(Y, X, P) float32 counts that functions of the table, one after the other, add to it; to read only.

        Zones last, as they are read together. It is kept: equal functions are taken to add the same.
        """
        with self._adding:
            made = self._added.pop(drawings, None)
            if made is not None:
                self._added[drawings] = made
                return made
        table = self.table
        for drawing in drawings:
            table = drawing(table)
        made = np.ascontiguousarray(np.moveaxis(table - self.table, 0, -1), np.float32)
        with self._adding:
            self._added[drawings] = made
            while len(self._added) > KEPT:
                del self._added[next(iter(self._added))]
        return made


@njit(nogil=True, cache=True)
def _beyond(x, y, ends, responses, reach):
    """(N, P) responses at N points beyond the hull, whose E edges have ends (E, 2, 2) and responses (E, 2, P)."""
    found = np.zeros((x.size, responses.shape[2]))
    low_x, high_x = ends[:, :, 0].min() - reach, ends[:, :, 0].max() + reach
    low_y, high_y = ends[:, :, 1].min() - reach, ends[:, :, 1].max() + reach
    for i in range(x.size):
        if not (low_x < x[i] < high_x and low_y < y[i] < high_y):
            continue  # Most of an image is: no edge has to be asked.
        nearest, edge, along = reach * reach, -1, 0.0
        for e in range(len(ends)):
            away_x, away_y = x[i] - ends[e, 0, 0], y[i] - ends[e, 0, 1]
            edge_x, edge_y = ends[e, 1, 0] - ends[e, 0, 0], ends[e, 1, 1] - ends[e, 0, 1]
            t = (away_x * edge_x + away_y * edge_y) / (edge_x * edge_x + edge_y * edge_y)
            t = min(max(t, 0.0), 1.0)
            distance = (away_x - t * edge_x) ** 2 + (away_y - t * edge_y) ** 2
            if distance < nearest:
                nearest, edge, along = distance, e, t
        if edge >= 0:
            left = 1 - np.sqrt(nearest) / reach
            for p in range(found.shape[1]):
                found[i, p] = left * ((1 - along) * responses[edge, 0, p] + along * responses[edge, 1, p])
    return found

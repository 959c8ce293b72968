"""Where each zone looks, on the grid of a camera: response maps resampled, moved and changed."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.interpolate import LinearNDInterpolator
from scipy.spatial import Delaunay, QhullError

from physics.geometry import full_size_pixels
from recordings.maps import ResponseMaps
from recordings.refusal import Refusal

Change = Callable[[np.ndarray], np.ndarray]


class FootprintField:
    """Responses of P zones at any point of the full-size image, counts.

    Linear on the Delaunay triangles of the scan points, 0 outside their hull. Call with x, y (...) in pixels of the
    full-size image: (P, ...).
    """

    def __init__(self, maps: ResponseMaps) -> None:
        self.full_size = maps.image_size
        points = np.stack([maps.xs, maps.ys], axis=1).astype(float)
        try:
            triangles = Delaunay(points)
        except (QhullError, ValueError):
            raise Refusal(
                f"response maps: {len(points)} scan points span no triangle, expected points off one line"
            ) from None
        self._interpolate = LinearNDInterpolator(triangles, maps.by_zone.T.astype(float), fill_value=0)

    def __call__(self, x_px: np.ndarray, y_px: np.ndarray) -> np.ndarray:
        """(P, ...) responses at image points."""
        return np.moveaxis(self._interpolate(x_px, y_px), -1, 0)


@dataclass(frozen=True, eq=False)
class Footprints:
    """The weight of every pixel for every zone.

    field: the maps. x_px, y_px: (H, W), or (F, H, W) where footprints move from frame to frame: where in the full-size
    image each pixel's weights are read. scale: counts that weigh 1, the same for all zones.
    changes: functions of weights (..., P, H, W), applied in order after the reading.
    """

    field: FootprintField
    x_px: np.ndarray
    y_px: np.ndarray
    scale: float
    changes: tuple[Change, ...] = ()

    @cached_property
    def weights(self) -> np.ndarray:
        """(P, H, W), or (F, P, H, W) where footprints move from frame to frame."""
        read = self.field(self.x_px, self.y_px) / self.scale
        weights = np.moveaxis(read, 0, -3)
        for change in self.changes:
            weights = change(weights)
        return weights

    @cached_property
    def seen(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """For all frames (one entry) or each: pixels (N,) that any zone sees, and their weights (N, P) float32."""
        stacks = self.weights if self.weights.ndim == 4 else self.weights[None]
        found = []
        for stack in stacks:
            by_pixel = stack.reshape(len(stack), -1).T
            pixels = np.flatnonzero(by_pixel.any(axis=1))
            found.append((pixels, np.ascontiguousarray(by_pixel[pixels], np.float32)))
        return found

    def moved(self, x_px: np.ndarray, y_px: np.ndarray) -> "Footprints":
        """The footprints displaced in the full-size image by x, y pixels: scalars, (H, W) or (F, H, W)."""
        return replace(self, x_px=self.x_px - x_px, y_px=self.y_px - y_px)

    def changed(self, change: Change) -> "Footprints":
        """The footprints with `change` applied to their weights (..., P, H, W), after what was applied before."""
        return replace(self, changes=(*self.changes, change))


def footprints(maps: ResponseMaps, shape: tuple[int, int]) -> Footprints:
    """The nominal footprints on a grid of `shape` (H, W), divided by one number: the largest response on that grid."""
    field = FootprintField(maps)
    x, y = full_size_pixels(shape, field.full_size)
    read = field(x, y)
    largest = float(read.max())
    if not largest > 0:
        raise Refusal(f"response maps: no response above 0 on the {shape[1]} x {shape[0]} camera grid, expected some")
    made = Footprints(field, x, y, largest)
    made.__dict__["weights"] = read / largest  # What `weights` would read a second time.
    return made

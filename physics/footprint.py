"""Where each zone looks, on the grid of a camera: response maps resampled, redrawn, moved and changed."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache

import numpy as np

from physics.bilinear import add_bilinear
from physics.footprint_field import FootprintField
from physics.geometry import full_size_pixels
from physics.workers import in_parallel
from recordings.maps import ResponseMaps
from recordings.refusal import Refusal

Change = Callable[[np.ndarray], np.ndarray]
# What was read where footprints moved to is kept where it is no more numbers than this.
MANY = 1 << 22
# Drawings of which it is kept what they add where footprints were read at first.
DRAWN = 24


@dataclass(frozen=True, eq=False)
class Footprints:
    """The weight of every pixel for every zone.

    field: the maps. x_px, y_px: (H, W), or (F, H, W) where footprints move from frame to frame: where in the full-size
    image each pixel's weights are read. scale: counts that weigh 1, the same for all zones. zone_grid: rows, columns.
    calibration_range_m: depth at which the maps were taken, infinity where unknown.
    drawings: functions of the maps as a table (P, Y, X), applied in order before the reading; equal ones draw alike.
    changes: functions of weights (..., P, H, W), applied in order after the reading.
    unmoved: the nominal footprints that these were made from; None where these are they.
    by_zone: (2, P) pixels x, y by which each zone is displaced beside that; None where none is.
    by_pixels: part of what is moved by all that is read between the weights of nominal pixels, not from maps.
    read: what was read before it was redrawn, by frame, for all that are where these are.

    Footprints are read from the triangles of the scan, moved or not. Maps end at the hull of the scan, with a jump
    where they have not fallen to 0. Moved ones fade beyond it, so that counts are continuous in the move, and what
    fading adds to a pixel is taken off as long as it has moved little: a move by 0 is none. What a drawing adds is the
    difference of two tables of whole pixels, read bilinearly at one place: a drawing that changes nothing adds nothing.
    """

    field: FootprintField
    x_px: np.ndarray
    y_px: np.ndarray
    scale: float
    zone_grid: tuple[int, int]
    calibration_range_m: float = np.inf
    drawings: tuple[Change, ...] = ()
    changes: tuple[Change, ...] = ()
    unmoved: "Footprints | None" = None
    by_zone: np.ndarray | None = None
    by_pixels: float = 0.0
    read: dict[int, np.ndarray] = field(default_factory=dict, repr=False)

    @cached_property
    def weights(self) -> np.ndarray:
        """(P, H, W), or (F, P, H, W) where footprints move from frame to frame."""
        if self.x_px.ndim == 3:
            read = np.stack([self._read(i) for i in range(len(self.x_px))])
        else:
            read = self._nominal if self.unmoved is None else self._read()
        weights = np.moveaxis(read, -1, -3)
        for change in self.changes:
            weights = change(weights)
        return weights

    @cached_property
    def seen(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """For all frames (one entry) or each: pixels (N,) that any zone sees, and their weights (N, P) float32."""

        def kept(by_pixel: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            by_pixel = by_pixel.reshape(-1, by_pixel.shape[-1])
            pixels = np.flatnonzero(by_pixel.any(axis=1))
            return pixels, np.ascontiguousarray(by_pixel[pixels], np.float32)

        if self.x_px.ndim == 3 and not self.changes:  # Frame by frame: those of all at once may be large.
            return [kept(self._read(i)) for i in range(len(self.x_px))]
        stacks = self.weights if self.weights.ndim == 4 else self.weights[None]
        return in_parallel(kept, np.moveaxis(stacks, 1, -1))

    def _read(self, frame: int = 0) -> np.ndarray:
        """(H, W, P) weights of one frame, moved and redrawn, before changes."""
        x_px, y_px = (a[frame] if a.ndim == 3 else a for a in (self.x_px, self.y_px))
        read = self.read.get(frame)
        if read is None and self.by_zone is not None:
            moved = ((x_px - x, y_px - y, p) for p, (x, y) in enumerate(self.by_zone.T))
            self.read[frame] = read = np.concatenate([self._moved(*each) for each in moved], axis=-1)
        if read is None:
            read = self._moved(x_px, y_px)
            if self.x_px.size * read.shape[-1] <= MANY:
                self.read[frame] = read
        read = read.copy()
        if self.drawings and self.by_zone is None and x_px is self.unmoved.x_px:
            read += self.unmoved._drawn(self.drawings)
        elif self.drawings:
            add_bilinear(self.field.added(self.drawings), *self.field.first, x_px, y_px, self.scale, read)
        return np.maximum(read, 0, out=read)

    @cached_property
    def _drawn(self) -> Callable[[tuple[Change, ...]], np.ndarray]:
        """What drawings add to weights read here, (H, W, P); kept, as maps are large and fits come back to the same."""

        @lru_cache(DRAWN)
        def added(drawings: tuple[Change, ...]) -> np.ndarray:
            found = np.zeros_like(self._nominal)
            add_bilinear(self.field.added(drawings), *self.field.first, self.x_px, self.y_px, self.scale, found)
            return found

        return added

    def _moved(self, x_px: np.ndarray, y_px: np.ndarray, zone: int | None = None) -> np.ndarray:
        """(H, W, P) weights read at these points, (H, W) each. zone: (H, W, 1), of it alone."""
        nominal = self.unmoved
        if x_px is nominal.x_px:
            return nominal._nominal
        if self.by_pixels and zone is None:
            between = self._between(x_px, y_px)
            if self.by_pixels == 1:
                return between
        read = np.moveaxis(self.field.faded(x_px, y_px, zone), 0, -1) / self.scale
        at, added = nominal._fading
        square = (x_px[at] - nominal.x_px[at]) ** 2 + (y_px[at] - nominal.y_px[at]) ** 2
        # Smooth at 0, where it is most often differentiated.
        near = np.maximum(1 - square / self.field.reach_px**2, 0)
        read[at] -= near[:, None] * (added if zone is None else added[:, zone : zone + 1])
        return read + self.by_pixels * (between - read) if self.by_pixels and zone is None else read

    def _between(self, x_px: np.ndarray, y_px: np.ndarray) -> np.ndarray:
        """(H, W, P) what lies between the weights of nominal pixels at these points; outside them there is nothing."""
        table, homes = self.unmoved._nominal, (self.unmoved.x_px[0], self.unmoved.y_px[:, 0])
        found = np.zeros((*x_px.shape, table.shape[-1]))
        steps = (h[1] - h[0] if len(h) > 1 else size for h, size in zip(homes, self.field.full_size, strict=True))
        at = [(a - h[0]) / step for a, h, step in zip((x_px, y_px), homes, steps, strict=True)]
        add_bilinear(table, 0, 0, *at, 1.0, found)
        return found

    @cached_property
    def _nominal(self) -> np.ndarray:
        """(H, W, P) weights where nothing is moved, redrawn or changed."""
        return np.moveaxis(self.field(self.x_px, self.y_px), 0, -1) / self.scale

    @cached_property
    def _fading(self) -> tuple[tuple[np.ndarray, np.ndarray], np.ndarray]:
        """Rows and columns, (N,) each, of pixels to which fading adds, and what, (N, P)."""
        added = np.moveaxis(self.field.faded(self.x_px, self.y_px), 0, -1) / self.scale - self._nominal
        at = np.nonzero(added.any(axis=-1))
        return at, added[at]

    @property
    def before_moving(self) -> "Footprints":
        """The nominal footprints where these were moved or redrawn; themselves where they were changed otherwise."""
        return self if self.unmoved is None or self.changes else self.unmoved

    def read_at(self, x_px: np.ndarray, y_px: np.ndarray) -> "Footprints":
        """The footprints on another grid, of pixels at these places of the full-size image, (H, W) each."""
        return replace(self, x_px=x_px, y_px=y_px, read={})

    def moved(self, x_px: np.ndarray | float, y_px: np.ndarray | float, by_pixels: float = 0.0) -> "Footprints":
        """The footprints displaced in the full-size image by x, y pixels: scalars, (H, W) or (F, H, W)."""
        x, y = (np.array(a) for a in np.broadcast_arrays(self.x_px - x_px, self.y_px - y_px))
        how = {"unmoved": self.unmoved or self, "by_pixels": max(self.by_pixels, by_pixels)}
        return replace(self, x_px=x, y_px=y, **how, read={})

    def zones_moved(self, x_px: np.ndarray, y_px: np.ndarray) -> "Footprints":
        """The footprints with each zone displaced by its own x, y pixels, (P,) each, and by what there was before."""
        before = 0.0 if self.by_zone is None else self.by_zone
        return replace(self, by_zone=before + np.stack([x_px, y_px]), unmoved=self.unmoved or self, read={})

    def redrawn(self, drawing: Change) -> "Footprints":
        """The footprints of maps changed by `drawing`, a function of (P, Y, X) counts at whole pixels."""
        return replace(self, drawings=(*self.drawings, drawing), unmoved=self.unmoved or self)

    def changed(self, change: Change) -> "Footprints":
        """The footprints with `change` applied to their weights (..., P, H, W), after what was applied before."""
        return replace(self, changes=(*self.changes, change))


def footprints(maps: ResponseMaps, shape: tuple[int, int], calibration_range_m: float | None = None) -> Footprints:
    """The nominal footprints on a grid of `shape` (H, W), divided by one number: the largest response on that grid.

    calibration_range_m: depth in metres at which the maps were taken, where their meta does not say.
    """
    field = FootprintField(maps)
    x, y = full_size_pixels(shape, field.full_size)
    read = np.moveaxis(field(x, y), 0, -1)
    largest = float(read.max())
    if not largest > 0:
        raise Refusal(f"response maps: no response above 0 on the {shape[1]} x {shape[0]} camera grid, expected some")
    depth = maps.meta.get("calibration_range_m", calibration_range_m)
    depth = np.inf if depth is None else depth
    if isinstance(depth, bool) or not isinstance(depth, int | float) or not depth > 0:
        raise Refusal(f"response maps: calibration_range_m is {depth!r}, expected metres above 0")
    made = Footprints(field, x, y, largest, maps.zone_grid, float(depth))
    made.__dict__["_nominal"] = read / largest  # What it would read a second time.
    return made

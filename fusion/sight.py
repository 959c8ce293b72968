"""Where a rig's zones look on its camera's grid: made once, used for every frame."""

from dataclasses import dataclass, replace
from functools import cached_property

import cv2
import numpy as np

from fusion.mount import baseline
from physics.footprint import Footprints, footprints
from physics.geometry import pixel_rays
from physics.rendering import Rendering
from physics.setting import Setting, in_order
from recordings.maps import ResponseMaps
from recordings.refusal import Refusal

# One pixel of the coarse grid stands for so many of the camera's in each direction; fewer where there would be less
# than so many columns.
COARSER, LEAST_COLUMNS = 8, 80
MOST_ZONES = 255
# A zone does not speak for pixels in which it responds with less than this part of its peak.
FAINT = 0.01


@dataclass(frozen=True, eq=False)
class Sight:
    """The footprints of P zones on an H × W camera grid, and the rig's geometry.

    weights: (P, H, W) float32, 1 at the largest response of all zones. intrinsics: (3, 3) pixels of the grid.
    zone_grid: rows, columns. baseline_m: (3,) the LiDAR's place in the camera's frame. calibration_range_m: depth at
    which the maps were taken, where parallax vanishes; infinity where unknown. footprints: the maps themselves on the
    grid, as the forward model takes them; None where the weights were made from others.
    """

    weights: np.ndarray
    intrinsics: np.ndarray
    zone_grid: tuple[int, int]
    baseline_m: np.ndarray
    calibration_range_m: float
    footprints: Footprints | None = None

    @property
    def shape(self) -> tuple[int, int]:
        """(H, W)."""
        return self.weights.shape[1:]

    @property
    def zones(self) -> int:
        """P."""
        return len(self.weights)

    @cached_property
    def rays(self) -> np.ndarray:
        """(H, W, 3) float32 ray through each pixel's centre, of length 1 along z."""
        return pixel_rays(self.intrinsics, self.shape).astype(np.float32)

    @cached_property
    def ray_length(self) -> np.ndarray:
        """(H, W) float32 range over depth of each pixel."""
        return np.linalg.norm(pixel_rays(self.intrinsics, self.shape), axis=-1).astype(np.float32)

    @cached_property
    def normalised(self) -> np.ndarray:
        """(P, H, W) float32 weights, each zone divided by its own largest (Behari & Raskar 2026, Eq. 3)."""
        peaks = self.weights.max(axis=(1, 2), keepdims=True)
        return np.ascontiguousarray(self.weights / np.where(peaks > 0, peaks, 1), np.float32)

    @cached_property
    def heard(self) -> np.ndarray:
        """(P, H, W) float32 the same, 0 where a zone responds with less than `FAINT` of its peak."""
        return np.where(self.normalised < FAINT, np.float32(0), self.normalised)

    @cached_property
    def spans(self) -> np.ndarray:
        """(P, H, 2) first column in which a zone is heard, and the one after the last; both 0 where there is none."""
        there = self.heard > 0
        first, last = there.argmax(axis=2), there.shape[2] - there[:, :, ::-1].argmax(axis=2)
        return np.where(there.any(axis=2)[..., None], np.stack([first, last], axis=-1), 0)

    @cached_property
    def stretch(self) -> np.ndarray:
        """(P,) range over depth in the middle of each zone's footprint."""
        total = np.maximum(self.weights.sum(axis=(1, 2)), np.finfo(np.float32).tiny)
        return (self.weights * self.ray_length).sum(axis=(1, 2)) / total

    @cached_property
    def coarse(self) -> "Sight":
        """The same field on a grid up to eight times as coarse: weights and rays are means over what a pixel covers."""
        coarser = max(1.0, min(COARSER, self.shape[1] / LEAST_COLUMNS))
        height, width = (max(1, round(n / coarser)) for n in self.shape)
        # OpenCV takes few channels at once, so one zone after another.
        weights = [cv2.resize(w, (width, height), interpolation=cv2.INTER_AREA) for w in self.weights]
        there = rescaled(self.intrinsics, width / self.shape[1], height / self.shape[0])
        return Sight(np.stack(weights), there, self.zone_grid, self.baseline_m, self.calibration_range_m)

    def shift_px(self, range_m: np.ndarray) -> np.ndarray:
        """(..., P, 2) x and y in pixels of the grid by which each zone's footprint lies beside its map.

        range_m: (..., P) of a surface that fills the zone, NaN where there is none: no shift. The shift is
        f·b·(1/z − 1/z_cal), disparity less its value in the scan (Hartley & Zisserman, Multiple View Geometry, 2nd ed.,
        §9; `physics.effects.parallax`). The part of the baseline along the optical axis is left out: it moves a pixel
        by b_z/z of its distance from the image's middle.
        """
        with np.errstate(divide="ignore", invalid="ignore"):
            nearer = self.stretch / np.asarray(range_m, float) - 1 / self.calibration_range_m
        nearer = np.where(np.isfinite(nearer), nearer, 0.0)
        return nearer[..., None] * (self.intrinsics[:2, :2] @ self.baseline_m[:2])

    def moved(self, range_m: np.ndarray) -> "Sight":
        """The sight of surfaces at these ranges (P,): each zone's footprint displaced by `shift_px`, bilinear."""
        if not self.baseline_m[:2].any():
            return self
        height, width = self.shape
        weights = [
            cv2.warpAffine(weight, np.array([[1, 0, x], [0, 1, y]]), (width, height))
            for weight, (x, y) in zip(self.weights, self.shift_px(range_m), strict=True)
        ]
        return replace(self, weights=np.stack(weights), footprints=None)


def rescaled(intrinsics: np.ndarray, across: float, down: float) -> np.ndarray:
    """(3, 3) of a grid with so many times the columns and rows over the same field."""
    # Pixel centres are at integers: x_new = (x + ½)·across − ½.
    half = np.array([[1.0, 0, 0.5], [0, 1, 0.5], [0, 0, 1]])
    return np.linalg.inv(half) @ np.diag([across, down, 1.0]) @ half @ intrinsics


def sight(
    maps: ResponseMaps,
    shape: tuple[int, int],
    intrinsics: np.ndarray,
    lidar_from_camera: np.ndarray | None = None,
    *,
    effects: tuple[Setting, ...] = (),
    calibration_range_m: float | None = None,
) -> Sight:
    """The sight of a rig on a camera grid of `shape` (H, W), which covers the same field as the maps' full-size image.

    intrinsics: (3, 3) pixels of the grid. lidar_from_camera: (4, 4) rigid, metres; where None, the maps' own, else no
    baseline. effects: those of a sensor; what they do to footprints is done here. calibration_range_m: metres, where
    the maps do not say. Raises `Refusal` where maps and grid do not fit.
    """
    height, width = shape
    full_width, full_height = maps.image_size
    if height < 1 or width < 1:
        raise Refusal(f"camera grid is {width} x {height} pixels, expected 1 or more each way")
    inside = (maps.xs > -0.5) & (maps.xs < full_width - 0.5) & (maps.ys > -0.5) & (maps.ys < full_height - 0.5)
    if not inside.any():
        raise Refusal(
            f"response maps: no scan point lies in their {full_width} x {full_height} image, "
            "expected image_size in meta_json to be that of the scan's camera"
        )
    where = footprints(maps, shape, calibration_range_m)
    if where.weights.shape[0] > MOST_ZONES:
        raise Refusal(f"response maps: {where.weights.shape[0]} zones, expected {MOST_ZONES} at most")
    aside = baseline(maps, lidar_from_camera)
    for setting in in_order(tuple(effects)):
        if setting.effect.id == "parallax":  # It goes by depth, which is to be found.
            aside = aside + np.array([setting.values["x"], setting.values["y"], 0.0])
        elif setting.effect.changes == ("footprints",):
            where = setting.effect.apply("footprints", setting.values, Rendering(None, where, None, 1.0))
    weights = np.ascontiguousarray(where.weights, np.float32)
    return Sight(weights, np.asarray(intrinsics, float), maps.zone_grid, aside, where.calibration_range_m, where)

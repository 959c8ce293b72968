"""A bright disc measured to a fraction of a pixel from the points of its rim."""

from dataclasses import dataclass

import cv2
import numpy as np

from calibrate.patch_circle import NORMALS, RAYS, Expected, fit_circle

STEP_PX = 0.5
SMOOTH_PX = 0.8
RIM_PX = 2.0  # A ray counts only where the image reaches this far on both sides of the rim.
REFINE_PX = 3.0
PASSES, SETTLED_PX = 5, 0.02
LEAST_ARC = 1 / 6
WEAK = 0.5  # Falls below this share of the rim's upper quartile are not the rim.
EVEN = 0.35  # Brightness inside may depart from that next to the rim by this share of the contrast.


@dataclass(frozen=True)
class Disc:
    """A disc brighter than its surround, as one image shows it.

    x_px, y_px: centre, pixel centres at integers. radius_px: where the rim is steepest, which a blur of standard
    deviation s moves inwards by s²/2r without moving the centre.
    sigma_px: standard error of the centre along one axis. noise_px: standard deviation per ray behind it.
    confidence: 0 to 1, the share of the visible rim that was found times the share of the inside that is even.
    contrast: counts, median step across the rim. arc: 0 to 1, how much of the rim the image holds.
    """

    x_px: float
    y_px: float
    radius_px: float
    sigma_px: float
    noise_px: float
    confidence: float
    contrast: float
    arc: float


def fit_disc(grey: np.ndarray, x_px: float, y_px: float, expected: Expected, search_px: float) -> Disc | None:
    """Fit a disc to the rim within `search_px` of a guessed circle; None where no rim supports one.

    grey: (H, W) uint8. Rim points are where brightness falls most steeply along rays from the centre, so that only
    discs brighter than their surround have any. A well known radius steadies the fit where the border of the image
    or a glare hides part of the rim.
    """
    patch = _Polar.around(grey, x_px, y_px, expected.radius_px + search_px + 3 * RIM_PX)
    if patch is None:
        return None
    x, y, radius = x_px, y_px, expected.radius_px
    reach = cut = search_px
    for _ in range(PASSES):
        distance, fall, visible = _rim(patch, x, y, radius, reach)
        if visible.sum() < LEAST_ARC * RAYS:
            return None
        usable = visible & (fall > max(WEAK * np.percentile(fall[visible], 75), 0))
        fit = fit_circle(distance, usable, visible, cut, expected)
        if fit is None or np.hypot(fit.dx_px, fit.dy_px) > 2 * reach or abs(fit.radius_px - radius) > 2 * reach:
            return None
        x, y, radius = x + fit.dx_px, y + fit.dy_px, fit.radius_px
        if np.hypot(fit.dx_px, fit.dy_px) < SETTLED_PX:
            break
        reach, cut = min(search_px, REFINE_PX), 0.0
    even, contrast = _inside(patch, x, y, radius, fit.inlier)
    support = fit.inlier.sum() / visible.sum()
    return Disc(x, y, radius, fit.sigma_px, fit.noise_px, float(support * even), contrast, float(visible.mean()))


@dataclass(frozen=True)
class _Polar:
    """A smoothed piece of an image, read along rays."""

    light: np.ndarray
    left: int
    top: int
    size: tuple[int, int]

    @staticmethod
    def around(grey: np.ndarray, x_px: float, y_px: float, half_px: float) -> "_Polar | None":
        left, top = max(int(x_px - half_px), 0), max(int(y_px - half_px), 0)
        right, bottom = int(x_px + half_px) + 2, int(y_px + half_px) + 2
        if min(right, grey.shape[1]) <= left or min(bottom, grey.shape[0]) <= top:
            return None
        piece = grey[top:bottom, left:right].astype(np.float32)
        smooth = cv2.GaussianBlur(piece, (0, 0), SMOOTH_PX, borderType=cv2.BORDER_REPLICATE)
        return _Polar(smooth, left, top, grey.shape[::-1])

    def read(self, x_px: float, y_px: float, radii_px: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Brightness (RAYS, M) at distances (M,) from a centre, and whether the image holds that point."""
        x, y = x_px + NORMALS[:, :1] * radii_px, y_px + NORMALS[:, 1:] * radii_px
        seen = (x >= 0) & (y >= 0) & (x <= self.size[0] - 1) & (y <= self.size[1] - 1)
        at = (x - self.left).astype(np.float32), (y - self.top).astype(np.float32)
        return cv2.remap(self.light, *at, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE), seen


def _rim(
    patch: _Polar, x_px: float, y_px: float, radius_px: float, reach_px: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Distance (RAYS,) of the steepest fall along each ray, to a fraction of a step, how steep, and visible or not."""
    start = max(radius_px - reach_px - RIM_PX, STEP_PX)
    radii = np.arange(start, radius_px + reach_px + RIM_PX + STEP_PX, STEP_PX)
    light, seen = patch.read(x_px, y_px, radii)
    fall = np.where(seen[:, 2:] & seen[:, :-2], light[:, :-2] - light[:, 2:], 0)
    middle = radii[1:-1]
    visible = seen[:, np.abs(radii - radius_px) <= RIM_PX].all(axis=1)
    window = np.flatnonzero(np.abs(middle[1:-1] - radius_px) <= reach_px) + 1
    best = window[0] + fall[:, window].argmax(axis=1)
    rays = np.arange(RAYS)
    before, at, after = fall[rays, best - 1], fall[rays, best], fall[rays, best + 1]
    bend = np.minimum(before - 2 * at + after, -1e-6)
    offset = np.clip((before - after) / (2 * bend), -1, 1)
    return middle[best] + STEP_PX * offset, at, visible


def _inside(patch: _Polar, x_px: float, y_px: float, radius_px: float, rim: np.ndarray) -> tuple[float, float]:
    """How much of the inside is as bright as next to the rim, 0 to 1, and the step in brightness across the rim.

    A ring is bright next to its outer rim only, which tells it from a disc.
    """
    beside = np.array([RIM_PX + 0.5, RIM_PX + 1.5])
    inner = np.linspace(0.2, 0.9, 8) * (radius_px - RIM_PX)
    light, seen = patch.read(x_px, y_px, np.concatenate([inner, radius_px - beside, radius_px + beside]))
    level = np.median(light[rim, 8:10])
    contrast = float(level - np.median(light[rim, 10:]))
    inside = light[:, :8][seen[:, :8]]
    return float(np.mean(np.abs(inside - level) < EVEN * contrast)) if len(inside) else 0.0, contrast

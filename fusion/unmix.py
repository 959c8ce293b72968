"""Unmixing: the depth image that has the zones' histograms, smooth but for where colour changes.

1. Each zone's light becomes a distribution of area over range (`shares`).
2. Its mean is that of the logarithm of range over the zone's footprint: kriging finds the smoothest such image.
3. Its shape is that of the image's own distribution in the footprint: descent makes them alike (`matching`).
"""

from dataclasses import replace

import cv2
import numpy as np

from fusion.edges import Field, guided_field
from fusion.kriging import krige
from fusion.matching import match
from fusion.prior import Prior
from fusion.shares import Shares, shares
from fusion.sight import Sight
from fusion.upsample import upsample, upsample_guided
from fusion.zone_view import ZoneDepths
from physics.geometry import incidence_cosine
from recordings.refusal import Refusal

PRIOR = Prior()
# Kriging has a constant of its own: its field needs a pull to 0 only to be invertible.
INTRINSIC = 1e-6
# Darker than this, colour says nothing of reflectance; no surface is seen at a grazing angle below this cosine.
DARKEST, GRAZING = 0.05, 0.1
# A pixel to which zones respond with less than this part of their largest responses is not seen.
UNSEEN = 0.01


def unmix(
    sight: Sight,
    depths: ZoneDepths,
    rgb: np.ndarray | None,
    *,
    before: np.ndarray | None = None,
    prior: Prior = PRIOR,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Depth, sigma (metres) and confidence, all (H, W) float32, of one frame.

    depths: of one frame, (P,). rgb: (H, W, 3) uint8, None where the camera gave nothing: no edges are known then.
    before: (h, w) metres on the coarse grid, what an earlier frame says of this view (`carried`), NaN where nothing.
    Depth and sigma are NaN, and confidence 0, where no zone that reports a range sees the pixel. Raises `Refusal` where
    there are other zones than maps, or images of another shape.
    """
    if depths.mean_m.shape != (sight.zones,):
        raise Refusal(f"depths are of shape {depths.mean_m.shape}, expected one for each of {sight.zones} zones")
    if rgb is not None and rgb.shape != (*sight.shape, 3):
        raise Refusal(f"rgb has shape {rgb.shape}, expected {(*sight.shape, 3)}")
    grid = sight.coarse
    if before is not None and before.shape != grid.shape:
        raise Refusal(f"before has shape {before.shape}, expected the coarse grid's {grid.shape}")
    observed = shares(depths, prior.certain)
    if not len(observed.zones):
        nothing = np.full(sight.shape, np.nan, np.float32)
        return nothing, nothing.copy(), np.zeros(sight.shape, np.float32)
    field = guided_field(rgb, grid.shape, prior.colour, prior.left, INTRINSIC)
    image = log_range(grid, observed, field, reflectance(rgb, grid.shape), before, prior)
    heard = grid.normalised[observed.zones]
    share = heard / np.maximum(heard.sum(axis=0), 1e-12)
    relative = np.sqrt(prior.least_sigma**2 + np.tensordot((prior.of_spread * observed.spread) ** 2, share, axes=1))
    depth = np.exp(image) / grid.ray_length
    full = upsample(depth, sight.shape) if rgb is None else upsample_guided(depth, rgb)
    confidence = np.clip(upsample(heard.sum(axis=0), sight.shape), 0, 1)
    seen = confidence > UNSEEN
    depth, sigma = (np.where(seen, a, np.float32(np.nan)) for a in (full, full * upsample(relative, sight.shape)))
    return depth, sigma, np.where(seen, confidence, np.float32(0))


def log_range(
    grid: Sight, observed: Shares, field: Field, bright: np.ndarray, before: np.ndarray | None, prior: Prior
) -> np.ndarray:
    """(h, w) logarithm of range in metres on the coarse grid; bright: (h, w) guess of reflectance."""
    weights = grid.weights[observed.zones].astype(float)
    heard = grid.normalised[observed.zones].astype(float)
    heard /= np.maximum(heard.sum(axis=0), 1)
    # Between none of the guess and all of it: colour says about half of what is to be known of near infrared.
    footprints = weights * np.sqrt(bright)
    footprints /= np.maximum(footprints.sum(axis=(1, 2), keepdims=True), 1e-30)
    image = krige(field, footprints, observed.mean, prior.mean_off)
    if before is not None:
        known = np.isfinite(before)
        image[known] = np.log(before[known] * grid.ray_length[known])
        off = observed.mean - footprints.reshape(len(footprints), -1) @ image.ravel()
        image += krige(field, footprints, off, prior.mean_off)
    local = replace(field, ridge=prior.ridge)
    for _ in range(prior.rounds):
        depth = (np.exp(image) / grid.ray_length).astype(np.float32)
        cosine = incidence_cosine(depth[None], grid.intrinsics)[0]
        areas = weights * np.clip(np.nan_to_num(cosine, nan=1.0), GRAZING, 1)
        image = match(local, image, heard, areas, observed, prior.steps)
    return image


def reflectance(rgb: np.ndarray | None, shape: tuple[int, int]) -> np.ndarray:
    """(h, w) guess on a grid of `shape`: mean of the linear colours (IEC 61966-2-1), as far as colour can say it."""
    if rgb is None:
        return np.ones(shape)
    small = cv2.resize(rgb, shape[::-1], interpolation=cv2.INTER_AREA) / 255
    linear = np.where(small <= 0.04045, small / 12.92, ((small + 0.055) / 1.055) ** 2.4)
    return np.clip(linear.mean(axis=-1), DARKEST, 1)

"""Unmixing: the depth image that has the zones' histograms, smooth but for where colour changes.

1. Each zone's light becomes a distribution of area over range (`shares`).
2. Its mean is that of the logarithm of range over the zone's footprint: kriging finds the smoothest such image,
   through what the images of a camera that moves tell (`told`).
3. Its shape is that of the image's own distribution in the footprint: descent makes them alike (`matching`).
"""

from dataclasses import replace

import cv2
import numpy as np

from fusion.edges import Field, guided_field
from fusion.matching import match
from fusion.motion import Motion
from fusion.prior import Prior
from fusion.shares import Shares, shares
from fusion.sight import Sight
from fusion.smoothest import Points, smoothest
from fusion.told import told
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
    motion: Motion | None = None,
    prior: Prior = PRIOR,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Depth, sigma (metres) and confidence, all (H, W) float32, of one frame.

    depths: of one frame, (P,). rgb: (H, W, 3) uint8, None where the camera gave nothing: no edges are known then.
    motion: an earlier image of the same camera and how it moved since; it tells nothing without `rgb`.
    Depth and sigma are NaN, and confidence 0, where no zone that reports a range sees the pixel. Raises `Refusal` where
    there are other zones than maps, or images of another shape.
    """
    if depths.mean_m.shape != (sight.zones,):
        raise Refusal(f"depths are of shape {depths.mean_m.shape}, expected one for each of {sight.zones} zones")
    if rgb is not None and rgb.shape != (*sight.shape, 3):
        raise Refusal(f"rgb has shape {rgb.shape}, expected {(*sight.shape, 3)}")
    grid = sight.coarse
    observed = shares(depths, prior.certain)
    if not len(observed.zones):
        nothing = np.full(sight.shape, np.nan, np.float32)
        return nothing, nothing.copy(), np.zeros(sight.shape, np.float32)
    field = guided_field(rgb, grid.shape, prior.colour, prior.left, INTRINSIC)
    points = None if rgb is None or motion is None else told(grid, observed, rgb, motion)
    image = log_range(grid, observed, field, reflectance(rgb, grid.shape), points, prior)
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
    grid: Sight,
    observed: Shares,
    field: Field,
    bright: np.ndarray,
    points: Points | None,
    prior: Prior,
) -> np.ndarray:
    """(h, w) logarithm of range in metres on the coarse grid.

    bright: (h, w) guess of reflectance. points: (h, w) logarithm of range and its precision, as images tell it.
    """
    weights = grid.weights[observed.zones].astype(float)
    heard = grid.normalised[observed.zones].astype(float)
    heard /= np.maximum(heard.sum(axis=0), 1)
    # Between none of the guess and all of it: colour says about half of what is to be known of near infrared.
    footprints = weights * np.sqrt(bright)
    footprints /= np.maximum(footprints.sum(axis=(1, 2), keepdims=True), 1e-30)
    image, firm = smoothest(field, footprints, observed, points, prior)
    local = replace(field, ridge=prior.ridge + firm)
    for _ in range(prior.rounds):
        depth = (np.exp(image) / grid.ray_length).astype(np.float32)
        cosine = incidence_cosine(depth[None], grid.intrinsics)[0]
        areas = weights * np.clip(np.nan_to_num(cosine, nan=1.0), GRAZING, 1)
        image = match(local, image, heard, areas, observed, prior.steps, prior.ridge)
    return image


def reflectance(rgb: np.ndarray | None, shape: tuple[int, int]) -> np.ndarray:
    """(h, w) guess on a grid of `shape`: mean of the linear colours (IEC 61966-2-1), as far as colour can say it."""
    if rgb is None:
        return np.ones(shape)
    small = cv2.resize(rgb, shape[::-1], interpolation=cv2.INTER_AREA) / 255
    linear = np.where(small <= 0.04045, small / 12.92, ((small + 0.055) / 1.055) ** 2.4)
    return np.clip(linear.mean(axis=-1), DARKEST, 1)

"""Plane sweep: how well each depth explains what another image of the same scene shows."""

import cv2
import numpy as np

# Side of the windows that are compared, pixels; the pixels of a window that count as independent.
WINDOW, INDEPENDENT = 5, 16.0
# Grey levels by which one surface differs from view to view, beside a brightness and a contrast of each window.
NOISE = 6.0
# Of a window all but rounding must be shown.
ALL = 0.999


def plane_sweep(
    now: np.ndarray,
    before: np.ndarray,
    intrinsics: tuple[np.ndarray, np.ndarray],
    step: np.ndarray,
    depth_m: np.ndarray,
) -> np.ndarray:
    """(D, h, w) float32 logarithm of the likelihood of each depth (D,) at each pixel; NaN where `before` shows it not.

    now: (h, w) and before: (H, W), grey images, 0 to 255, with `intrinsics` (3, 3) each; step: (4, 4) camera of
    `before` from that of `now`, metres; depth_m: in order. Planes across the optical axis of `now` at each depth take
    `before` to it (Collins 1996, A space-sweep approach to true multi-image matching, CVPR). Windows about a pixel
    agree but for a brightness, a contrast and normal noise: what the best line from one to the other leaves of the
    variance v of `now` is v·(1 - ρ²), ρ their correlation, 0 where that is negative.
    """
    inverse = np.linalg.inv(intrinsics[0])
    ways = [intrinsics[1] @ (step[:3, :3] + np.outer(step[:3, 3], [0, 0, 1 / z])) @ inverse for z in depth_m]
    # A pixel moves along a line as depth grows, and images are convex: what both ends show all depths do.
    ends = [_mean(_warped(np.ones(before.shape, np.float32), ways[k], now.shape)) for k in (0, -1)]
    hidden = np.minimum(*ends) < ALL
    there, other = now.astype(np.float32), before.astype(np.float32)
    mean = _mean(there)
    varied = np.maximum(_mean(there * there) - mean * mean, 0)
    found = np.empty((len(depth_m), *now.shape), np.float32)
    for one, way in zip(found, ways, strict=True):
        seen = _warped(other, way, now.shape)
        mean_there = _mean(seen)
        both = np.maximum(_mean(there * seen) - mean * mean_there, 0)
        # One grey level of rounding and blur varies even where nothing does.
        varied_there = np.maximum(_mean(seen * seen) - mean_there * mean_there, 0) + 1
        one[:] = np.minimum(both * both / varied_there, varied) - varied
    found *= INDEPENDENT / (2 * NOISE**2)
    found[:, hidden] = np.nan
    return found


def _warped(image: np.ndarray, way: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """(h, w) of an image where `way`, (3, 3), takes each pixel; 0 outside."""
    return cv2.warpPerspective(image, way, shape[::-1], flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP)


def _mean(image: np.ndarray) -> np.ndarray:
    """Means over windows, (h, w)."""
    return cv2.blur(image, (WINDOW, WINDOW), borderType=cv2.BORDER_REFLECT_101)

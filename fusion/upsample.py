"""A coarse image on the camera's grid, with its edges where the camera's are."""

import cv2
import numpy as np

# Radius in pixels of the coarse grid, and the variance of grey (white 1) that is no edge.
RADIUS, FLAT = 2, 1e-3


def upsample(coarse: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """(H, W) float32, bilinear; both grids cover the same view."""
    return cv2.resize(coarse.astype(np.float32), shape[::-1], interpolation=cv2.INTER_LINEAR)


def upsample_guided(coarse: np.ndarray, rgb: np.ndarray) -> np.ndarray:
    """(H, W) float32, locally linear in the grey of `rgb` (H, W, 3) uint8: the fast guided filter (He & Sun 2015).

    Coefficients are found on the coarse grid and upsampled, which costs little. What comes out lies between the
    least and the largest of `coarse`.
    """
    grey = cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY)
    small = cv2.resize(grey, coarse.shape[::-1], interpolation=cv2.INTER_AREA).astype(np.float32) / 255
    values = coarse.astype(np.float32)
    slope = (_mean(small * values) - _mean(small) * _mean(values)) / (_mean(small**2) - _mean(small) ** 2 + FLAT)
    offset = _mean(values) - slope * _mean(small)
    slope, offset = upsample(_mean(slope), grey.shape), upsample(_mean(offset), grey.shape)
    return np.clip(slope * (grey.astype(np.float32) / 255) + offset, values.min(), values.max())


def _mean(image: np.ndarray) -> np.ndarray:
    return cv2.blur(image, (2 * RADIUS + 1, 2 * RADIUS + 1), borderType=cv2.BORDER_REPLICATE)

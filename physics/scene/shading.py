"""What the camera beside the sensor sees of surfaces that have a colour: matt, under a soft light from above."""

import numpy as np

# Towards the light; the world's y axis points down.
LIGHT = np.array([0.25, -0.9, -0.35])
# Of a surface's brightness, the part that does not depend on which way it faces.
EVENLY = 0.4


def coded(bright: np.ndarray) -> np.ndarray:
    """Brightness 0 to 1 as sRGB (IEC 61966-2-1), 0 to 1."""
    return np.where(bright <= 0.0031308, 12.92 * bright, 1.055 * np.maximum(bright, 0.0031308) ** (1 / 2.4) - 0.055)


def linear(code: np.ndarray) -> np.ndarray:
    """sRGB 0 to 1 as brightness, 0 to 1: the inverse of `coded`."""
    return np.where(code <= 0.04045, code / 12.92, ((np.maximum(code, 0.04045) + 0.055) / 1.055) ** 2.4)


def shaded(colour: np.ndarray, normals: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """(N, 3) uint8 picture of surfaces of `colour` (N, 3), sRGB 0 to 1, NaN where there is none, which is black.

    normals: (N, 3) unit, of either sign. directions: (N, 3) in which the camera looks at them. The brightness goes
    from `EVENLY` to 1 with 1 + cos of the angle between the normal and the light, as of light from half the sky.
    """
    outward = np.where((normals * directions).sum(axis=-1, keepdims=True) > 0, -normals, normals)
    lit = (1 + outward @ (LIGHT / np.linalg.norm(LIGHT))) / 2
    bright = linear(colour) * (EVENLY + (1 - EVENLY) * lit)[:, None]
    return np.rint(255 * np.nan_to_num(coded(bright))).astype(np.uint8)

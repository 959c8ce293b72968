"""How brightly the emitter lights each pixel of a scan, as the maps of all zones together tell, and when it moves."""

import numpy as np
from scipy.ndimage import map_coordinates

from physics.blurring import blurred
from physics.footprint import Footprints

# Part of a zone's radius over which seams between zones are smoothed away.
SMOOTH = 0.5
# Part of the brightest by which the emitter lights at least: where no zone saw anything, nothing tells how dark it is.
LEAST = 0.03


def relit(footprints: Footprints, right: np.ndarray, down: np.ndarray) -> np.ndarray:
    """(F, H, W) by what pixels are brighter where the emitter's profile has moved right and down, (F, H, W) pixels.

    A zone's map is what the receiver sees there times what the emitter sends there. Where zones share the field evenly
    the sum of all maps is the emitter's profile E; seams between them are smoothed away. Moved by d it lights the pixel
    at u by E(u - d) / E(u) of what it did.
    """
    lit = _profile(footprints.before_moving.weights)
    rows, columns = np.indices(lit.shape)
    places = np.stack(np.broadcast_arrays(rows - down, columns - right))
    return map_coordinates(lit, places, order=1, mode="nearest") / lit


def _profile(weights: np.ndarray) -> np.ndarray:
    """(H, W) of the emitter, from weights (P, H, W), or (F, P, H, W)."""
    weights = weights.reshape(-1, *weights.shape[-3:]).mean(axis=0)
    total = weights.sum(axis=(1, 2))
    variance = 0.0
    for axis in (1, 2):
        along = weights.sum(axis=axis)
        at = np.arange(along.shape[1])
        mean = along @ at / np.maximum(total, 1e-12)
        variance = variance + (along * (at - mean[:, None]) ** 2).sum(axis=1) / np.maximum(total, 1e-12) / 2
    lit = blurred(weights.sum(axis=0), SMOOTH**2 * np.average(variance, weights=total))
    return np.maximum(lit, LEAST * lit.max())

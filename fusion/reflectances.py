"""Reflectances that nobody knows: drawn at random, one for each surface and patches upon it."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import label

# Patches of this part of the image's width, a choice.
PATCH = 0.06
# Neighbouring pixels whose ranges differ by more than this part are of two surfaces, a choice.
EDGE = 0.04


@dataclass(frozen=True, eq=False)
class Reflectances:
    """What to draw from. surface: (F, H, W) which surface of which frame a pixel is of, 0 between surfaces.

    down, across: (H, h) and (W, w) weights that make a smooth field of numbers on a coarse grid, of variance 1.
    """

    surface: np.ndarray
    down: np.ndarray
    across: np.ndarray

    @classmethod
    def of(cls, range_m: np.ndarray) -> "Reflectances":
        """For images of range (F, H, W), in metres, 0 or NaN where unknown."""
        _, height, width = range_m.shape
        return cls(_surfaces(range_m), _bells(height, PATCH * width), _bells(width, PATCH * width))

    def draw(self, rng: np.random.Generator) -> np.ndarray:
        """(F, H, W) of mean 0 and variance 1, a logarithm of reflectance: half the variance is of surfaces, half of
        patches, and half of these stay in view."""
        offsets = rng.standard_normal(int(self.surface.max()) + 1)
        patches = rng.standard_normal((len(self.surface) + 1, self.down.shape[1], self.across.shape[1]))
        patches = (patches[1:] + patches[0]) / np.sqrt(2)
        return (offsets[self.surface] + self.down @ patches @ self.across.T) / np.sqrt(2)


def _bells(size: int, sigma: float) -> np.ndarray:
    """(size, n) Gaussian weights about nodes that lie less than sigma apart, squares of a row sum to 1."""
    nodes = np.arange(-3 * sigma, size + 3 * sigma, 0.9 * sigma)
    weights = np.exp(-0.5 * ((np.arange(size)[:, None] - nodes) / sigma) ** 2)
    return weights / np.sqrt((weights**2).sum(axis=1, keepdims=True))


def _surfaces(range_m: np.ndarray) -> np.ndarray:
    """(F, H, W) numbers of what hangs together, in each frame by itself; 0 at edges and where nothing is known."""
    found, so_far = np.zeros(range_m.shape, int), 0
    for numbers, image in zip(found, range_m, strict=True):
        known = image > 0
        log = np.log(np.where(known, image, 1))
        flat = known.copy()
        flat[:, 1:] &= np.abs(np.diff(log, axis=1)) < EDGE
        flat[1:] &= np.abs(np.diff(log, axis=0)) < EDGE
        here, many = label(flat)
        numbers[:] = np.where(flat, here + so_far, 0)
        so_far += many
    return found

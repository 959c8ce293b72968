"""What differs from place to place in space: a number at each knot of a lattice, trilinear in between."""

from functools import lru_cache
from itertools import product

import numpy as np
from scipy.sparse import csr_array

from physics.kept import kept_of_session
from physics.light import Light
from physics.texture import places

# Knots along each side of the box that holds all that was seen, and the fullest of them, which have numbers. A side is
# taken to be at least this part of the longest: across a wall nothing varies.
SIDE, PATCHES, THIN = 6, 128, 0.25


def patchwork(numbers: np.ndarray, light: Light) -> np.ndarray:
    """(F, H, W) float32 number at what each pixel sees, of (PATCHES,) or one number for all.

    Knots are counted from the fullest: by the sum over all pixels of the session of how near what they see is to each.
    The others stay 0.
    """
    each = np.broadcast_to(np.asarray(numbers, np.float32), PATCHES)
    return (_weights(light) @ each).reshape(light.range_m.shape)


# Of the lights that were asked for last: a fit asks for the same with other numbers.
@lru_cache(maxsize=4)
def _weights(light: Light) -> csr_array:
    """(F·H·W, PATCHES) how near what a pixel sees is to each knot."""
    every = _of_session(light)
    if light.part_of is None:
        return every
    pixels = int(np.prod(light.range_m.shape[1:]))
    rows = (light.part_of[1][:, None] * pixels + np.arange(pixels)).ravel()
    return every[rows]


@kept_of_session
def _of_session(light: Light) -> csr_array:
    """The same of all frames of a session."""
    seen = (light.range_m > 0) & np.isfinite(light.range_m)
    along = np.stack([axis[seen] for axis in places(light)])
    if not seen.any():
        return csr_array((light.range_m.size, PATCHES), dtype=np.float32)
    low, long = along.min(axis=1, keepdims=True), np.ptp(along, axis=1, keepdims=True)
    at = (along - low) / np.maximum(long, max(THIN * float(long.max()), 1e-9)) * (SIDE - 1)
    knot = np.minimum(at.astype(int), SIDE - 2)
    part = at - knot
    corners = np.array(list(product((0, 1), repeat=3)))
    weights = np.prod(np.where(corners[:, :, None], part, 1 - part), axis=1)
    number = np.ravel_multi_index(tuple(np.moveaxis(knot + corners[:, :, None], 1, 0)), (SIDE,) * 3)
    fullest = np.argsort(-np.bincount(number.ravel(), weights.ravel(), SIDE**3), kind="stable")
    pixel = np.broadcast_to(np.flatnonzero(seen), number.shape)
    every = csr_array(
        (weights.ravel().astype(np.float32), (pixel.ravel(), number.ravel())), (light.range_m.size, SIDE**3)
    )
    return csr_array(every[:, fullest[:PATCHES]])

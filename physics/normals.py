"""Which way the surfaces of a frame face: the vector area of each pixel's piece of surface, from its ranges alone."""

from functools import lru_cache

import numpy as np
from numba import njit

from physics.geometry import _slope, inverse_pinhole
from physics.light import Light


def vector_areas(light: Light, frame: int) -> np.ndarray:
    """(H, W, 3) m² in the camera's frame: each pixel's area of surface times its normal, towards the sensor.

    Slopes are those of `incidence_cosine`. NaN where range or slope is unknown.
    """
    ranges = light.range_m[frame]
    known = np.isfinite(ranges) & (ranges > 0)
    depth = np.where(known, ranges / np.linalg.norm(light.rays, axis=-1), np.nan)
    areas = np.empty((*depth.shape, 3))
    _vector_areas(depth, light.rays, inverse_pinhole(light.intrinsics), areas)
    return areas


# Of the frames that choose and of those that judge.
@lru_cache(maxsize=2)
def facing(light: Light) -> np.ndarray:
    """(F, H, W, 3) vector areas of all frames; to read only."""
    return np.stack([vector_areas(light, i) for i in range(light.frames)])


def solid_angles(light: Light) -> np.ndarray:
    """(H, W) steradians that each pixel fills: its area on the plane z = 1, over |ray|³."""
    inverse = inverse_pinhole(light.intrinsics)
    return abs(inverse[0, 0] * inverse[1, 1]) / np.linalg.norm(light.rays, axis=-1) ** 3


@njit(nogil=True, cache=True)
def _vector_areas(depth, rays, inverse, out):
    """∂X/∂v × ∂X/∂u of X = z·ray; ∂X/∂u = z_u·ray + z·∂ray/∂u. It always faces the sensor: z is a function of u, v."""
    height, width = depth.shape
    ux, vx, vy = inverse[0, 0], inverse[0, 1], inverse[1, 1]
    for v in range(height):
        for u in range(width):
            x, y, z = rays[v, u, 0], rays[v, u, 1], depth[v, u]
            left = depth[v, u - 1] if u > 0 else np.nan
            right = depth[v, u + 1] if u < width - 1 else np.nan
            above = depth[v - 1, u] if v > 0 else np.nan
            below = depth[v + 1, u] if v < height - 1 else np.nan
            z_u, z_v = _slope(left, z, right), _slope(above, z, below)
            ax, ay, az = z_u * x + z * ux, z_u * y, z_u
            bx, by, bz = z_v * x + z * vx, z_v * y + z * vy, z_v
            out[v, u, 0] = by * az - bz * ay
            out[v, u, 1] = bz * ax - bx * az
            out[v, u, 2] = bx * ay - by * ax

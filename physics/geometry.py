"""A camera grid in space: rays through its pixels, its place in a full-size image, incidence of light on its depth."""

import numpy as np
from numba import njit

from physics.workers import in_parallel
from recordings.refusal import Refusal

# Cosine of surfaces as steep as edges are taken for.
STEEPEST = 0.05


def inverse_pinhole(intrinsics: np.ndarray) -> np.ndarray:
    """(3, 3) matrix that takes (u, v, 1) of a pixel to its ray of length 1 along z."""
    return np.linalg.inv(np.asarray(intrinsics, float))


def pixel_rays(intrinsics: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """(H, W, 3) ray through each pixel centre in the camera's frame, of length 1 along z."""
    v, u = np.mgrid[: shape[0], : shape[1]].astype(float)
    pixels = np.stack([u, v, np.ones_like(u)], axis=-1)
    return pixels @ inverse_pinhole(intrinsics).T


def full_size_pixels(shape: tuple[int, int], full_size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """(H, W) each: x and y of a grid's pixel centres in the full-size image of `full_size` width, height.

    The grid covers the same field: x_full = (x + ½)·W_full/W − ½.
    """
    v, u = np.mgrid[: shape[0], : shape[1]].astype(float)
    width, height = full_size
    return (u + 0.5) * width / shape[1] - 0.5, (v + 0.5) * height / shape[0] - 0.5


def incidence_cosine(depth_m: np.ndarray, intrinsics: np.ndarray) -> np.ndarray:
    """(F, H, W) float32 cosine between surface normal and ray to the camera, from depth (F, H, W) alone.

    The surface's slope along each image axis is that towards the neighbour nearer in depth, so that it does not cross
    an edge; where both are about as near it is the mean of the two. NaN where depth or both neighbours are unknown.
    """
    depth = np.require(depth_m, np.float32, ("C", "W"))
    if depth.ndim != 3:
        raise Refusal(f"depth_m has shape {depth.shape}, expected (F, H, W)")
    inverse, found = inverse_pinhole(intrinsics), np.empty_like(depth)
    in_parallel(lambda i: _cosines(depth[i], inverse, found[i]), range(len(depth)))
    return found


def incidence_cosine_across_edges(depth_m: np.ndarray, intrinsics: np.ndarray) -> np.ndarray:
    """(F, H, W) float32 of the same, by central differences of points wherever these lie, and 0.05 at least.

    As images of slopes are often made, edges of depth included, where they are slopes of nothing: the recording that
    is published for conformance has its own to 4e-6. What has an unknown neighbour is as `incidence_cosine` has it.
    """
    found = incidence_cosine(depth_m, intrinsics)
    rays = pixel_rays(intrinsics, found.shape[1:])
    for depth, cosine in zip(depth_m, found, strict=True):
        points = rays * np.asarray(depth, float)[..., None]
        normal = np.cross(np.gradient(points, axis=1), np.gradient(points, axis=0))
        size = np.linalg.norm(normal, axis=-1) * np.linalg.norm(points, axis=-1)
        across = np.abs((normal * points).sum(axis=-1)) / np.where(size > 0, size, np.nan)
        np.copyto(cosine, np.clip(across, STEEPEST, 1), where=np.isfinite(across))
    return found


@njit(nogil=True, cache=True)
def _slope(before, here, after):
    """Change of depth by pixel; NaN where no neighbour is known."""
    back, ahead = here - before, after - here
    if np.isnan(back):
        return ahead
    if np.isnan(ahead):
        return back
    a, b = abs(back), abs(ahead)
    if a > 2 * b:
        return ahead
    if b > 2 * a:
        return back
    return 0.5 * (back + ahead)


@njit(nogil=True, cache=True)
def _cosines(depth, inverse, out):
    """Normal = ∂X/∂u × ∂X/∂v of X = z·ray; ∂X/∂u = z_u·ray + z·∂ray/∂u."""
    height, width = depth.shape
    ux, vx, vy = inverse[0, 0], inverse[0, 1], inverse[1, 1]
    for v in range(height):
        y = vy * v + inverse[1, 2]
        for u in range(width):
            x = ux * u + vx * v + inverse[0, 2]
            z = float(depth[v, u])
            left = depth[v, u - 1] if u > 0 else np.nan
            right = depth[v, u + 1] if u < width - 1 else np.nan
            above = depth[v - 1, u] if v > 0 else np.nan
            below = depth[v + 1, u] if v < height - 1 else np.nan
            z_u, z_v = _slope(left, z, right), _slope(above, z, below)
            ax, ay, az = z_u * x + z * ux, z_u * y, z_u
            bx, by, bz = z_v * x + z * vx, z_v * y + z * vy, z_v
            nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
            size = np.sqrt((nx * nx + ny * ny + nz * nz) * (x * x + y * y + 1))
            out[v, u] = abs(nx * x + ny * y + nz) / size if size > 0 else np.nan

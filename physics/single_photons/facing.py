"""Which way surfaces face, by the points around each pixel's, and how much of the view a pixel fills."""

import numpy as np

from physics.single_photons.world import World


def facets(world: World) -> np.ndarray:
    """(H, W, 3) m²: area of the surface that each pixel sees, times its normal towards the sensor; NaN where unknown.

    The surface is the plane on which depth changes along either image axis as towards the neighbour nearer in depth,
    or as the mean of both where neither change is more than twice the other.
    """
    depth = np.where(world.depth_m > 0, world.depth_m, np.nan)
    across, down = _slope(depth.T).T, _slope(depth)
    rows, columns = np.indices(depth.shape)
    inverse = np.linalg.inv(world.intrinsics)

    def corner(right: float, below: float) -> np.ndarray:
        pixel = np.stack([columns + right, rows + below, np.ones(depth.shape)], axis=-1)
        return (depth + right * across + below * down)[..., None] * (pixel @ inverse.T)

    width = corner(1, 0) - corner(-1, 0)
    height = corner(0, 1) - corner(0, -1)
    area = np.cross(height, width) / 4
    away = (area * world.points).sum(axis=-1) > 0
    return np.where(away[..., None], -area, area)


def solid_angles(world: World) -> np.ndarray:
    """(H, W) steradians of each pixel: from rectangles with a corner on the axis, arctan(xy / sqrt(1 + x² + y²))."""
    rows, columns = (np.arange(n + 1) - 0.5 for n in world.depth_m.shape)
    pixel = np.stack([*np.meshgrid(columns, rows), np.ones((len(rows), len(columns)))], axis=-1)
    x, y, _ = np.moveaxis(pixel @ np.linalg.inv(world.intrinsics).T, -1, 0)
    to_axis = np.arctan(x * y / np.sqrt(1 + x**2 + y**2))
    return np.abs(np.diff(np.diff(to_axis, axis=0), axis=1))


def _slope(depth: np.ndarray) -> np.ndarray:
    """(H, W) change of depth from row to row."""
    beyond = np.full((1, depth.shape[1]), np.nan)
    before = np.diff(depth, axis=0, prepend=beyond)
    after = np.diff(depth, axis=0, append=beyond)
    before, after = np.where(np.isnan(before), after, before), np.where(np.isnan(after), before, after)
    small, large = np.minimum(abs(before), abs(after)), np.maximum(abs(before), abs(after))
    nearer = np.where(abs(before) < abs(after), before, after)
    return np.where(large > 2 * small, nearer, (before + after) / 2)

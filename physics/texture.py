"""What varies slowly over the view, or in space: polynomials of two and of three coordinates."""

from functools import lru_cache
from itertools import combinations_with_replacement

import numpy as np

from physics.effect import Values
from physics.light import Light
from physics.odometry import camera_motion

# Powers of the two coordinates of the view by name; those of third and fourth order by the letters of their product.
COARSE = {"slope_x": (1, 0), "slope_y": (0, 1), "bow_x": (2, 0), "bow_y": (0, 2), "bow_xy": (1, 1)}
FINE = {f"bend_{'x' * (n - k)}{'y' * k}": (n - k, k) for n in (3, 4) for k in range(n + 1)}
VIEW = COARSE | FINE
# Powers of the three coordinates of space.
SPACE = {
    f"space_{''.join(letters)}": tuple(letters.count(axis) for axis in "xyz")
    for order in (1, 2)
    for letters in combinations_with_replacement("xyz", order)
}
PRODUCTS = {name: "x" * i + "y" * j for name, (i, j) in VIEW.items()} | {name: name[6:] for name in SPACE}
# Metres ahead of the camera where the third coordinate is 0: amid what such a sensor sees, where its powers differ.
MIDDLE_M = 0.5


def texture(values: Values, light: Light) -> np.ndarray:
    """Value of the polynomials, (F, H, W) or what broadcasts to it; in space, what has no range is at the camera."""
    found = np.zeros(())
    for powers, products in ((VIEW, _of_view), (SPACE, _of_space)):
        factors = np.array([values[name] for name in powers], np.float32)
        if factors.any():
            found = found + np.tensordot(factors, products(light), 1)
    return found


# Kept for lights that were asked for last: a fit asks for the same again and again, with other factors.
@lru_cache(maxsize=4)
def _of_view(light: Light) -> np.ndarray:
    """(N, H, W) float32 products of tangents x/z, y/z."""
    return _products(list(np.moveaxis(light.rays[..., :2], -1, 0)), VIEW)


@lru_cache(maxsize=4)
def _of_space(light: Light) -> np.ndarray:
    """(N, F, H, W) float32 products of metres to the right, down, and ahead of `MIDDLE_M`.

    In the camera's frame when the session began.
    """
    right, down, ahead = places(light)
    return _products([right, down, ahead - MIDDLE_M], SPACE)


def places(light: Light) -> list[np.ndarray]:
    """Three (F, H, W): metres to the right, down and ahead, in the camera's frame when the session began.

    Where nobody says how it moved, what it sees says it.
    """
    range_m = np.where(np.isfinite(light.range_m), light.range_m, 0).astype(float)
    depth = range_m / np.linalg.norm(light.rays, axis=-1)
    motion = camera_motion(light)
    moved = motion.start_from_camera[motion.nearest(light.time_s)]
    rays = np.ascontiguousarray(np.moveaxis(light.rays, -1, 0))
    # Row by row of the transform, so that no array of points is made.
    return [np.tensordot(moved[:, row, :3], rays, 1) * depth + moved[:, row, 3][:, None, None] for row in range(3)]


def _products(coordinates: list[np.ndarray], powers: dict[str, tuple[int, ...]]) -> np.ndarray:
    """(N, ...) float32 products of coordinates (...) to these powers."""
    found = np.ones((len(powers), *coordinates[0].shape), np.float32)
    for product, orders in zip(found, powers.values(), strict=True):
        for coordinate, order in zip(coordinates, orders, strict=True):
            for _ in range(order):
                product *= coordinate
    return found


def passing(range_m: np.ndarray) -> float:
    """By what part of itself the range of a pixel (F, H, W) varies over the frames; the median of those seen in all."""
    seen = (range_m > 0).all(axis=0)
    if not seen.any():
        return 0.0
    ranges = range_m[:, seen]
    return float(np.median(np.ptp(ranges, axis=0) / ranges.mean(axis=0)))

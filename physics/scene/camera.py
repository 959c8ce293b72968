"""The camera grid that scenes without a camera of their own are seen through."""

import numpy as np

from recordings.maps import ResponseMaps
from recordings.refusal import Refusal

# A grid an eighth as fine as the image of the scan's camera, whose horizontal field is 69 degrees.
FINENESS = 8
HORIZONTAL_DEG = 69.4


def camera_of(maps: ResponseMaps) -> tuple[np.ndarray, tuple[int, int]]:
    """Intrinsics (3, 3) and size (width, height) of a grid over the field of the maps.

    The camera is that of the maps where they carry its intrinsics, else one of 69.4 degrees across.
    """
    full = maps.image_size
    size = (max(full[0] // FINENESS, 1), max(full[1] // FINENESS, 1))
    if "intrinsics" not in maps.meta:
        return pinhole(size, HORIZONTAL_DEG), size
    shrink = np.diag([size[0] / full[0], size[1] / full[1], 1.0])
    # Pixel centres are at integers: x_small = (x + ½)·shrink − ½.
    half = np.array([[1.0, 0, 0.5], [0, 1, 0.5], [0, 0, 1]])
    return np.linalg.inv(half) @ shrink @ half @ np.asarray(maps.meta["intrinsics"], float), size


def pinhole(size: tuple[int, int], horizontal_deg: float) -> np.ndarray:
    """(3, 3) matrix of a camera with square pixels and its axis in the middle of the image."""
    if not 0 < horizontal_deg < 180:
        raise Refusal(f"camera: horizontal_deg is {horizontal_deg}, expected between 0 and 180")
    focal = size[0] / 2 / np.tan(np.radians(horizontal_deg) / 2)
    return np.array([[focal, 0, (size[0] - 1) / 2], [0, focal, (size[1] - 1) / 2], [0, 0, 1]])

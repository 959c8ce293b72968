"""How strongly each zone sees a point of the image: response maps between the positions of their scan."""

import numpy as np
from scipy.interpolate import LinearNDInterpolator
from scipy.spatial import QhullError

from recordings.maps import ResponseMaps
from recordings.refusal import Refusal


def responses_at(maps: ResponseMaps, x_px: np.ndarray, y_px: np.ndarray) -> np.ndarray:
    """(P, ...) counts at points (...) of the full-size image: linear between scan positions, 0 outside their hull."""
    positions = np.column_stack([maps.xs, maps.ys]).astype(float)
    try:
        between = LinearNDInterpolator(positions, maps.by_zone.T.astype(float), fill_value=0.0)
    except (QhullError, ValueError):
        raise Refusal(f"response maps: {len(positions)} positions lie on a line, expected some off it") from None
    return np.moveaxis(between(x_px, y_px), -1, 0)


def pixel_places(maps: ResponseMaps, shape: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """(H, W) each: x and y in the full-size image of the pixel centres of a grid that covers the same field.

    Both images have their edges in the same places, half a pixel outside the centres of the outermost pixels.
    """
    width, height = maps.image_size
    x = np.linspace(-0.5, width - 0.5, 2 * shape[1] + 1)[1::2]
    y = np.linspace(-0.5, height - 0.5, 2 * shape[0] + 1)[1::2]
    return tuple(np.meshgrid(x, y))


def unit_response(maps: ResponseMaps, shape: tuple[int, int]) -> float:
    """Counts that weigh 1: the largest response on the grid of `shape` (H, W)."""
    largest = float(responses_at(maps, *pixel_places(maps, shape)).max())
    if not largest > 0:
        raise Refusal(f"response maps are {largest:g} at most on a {shape[1]} x {shape[0]} grid, expected above 0")
    return largest


def zone_weights(maps: ResponseMaps, shape: tuple[int, int]) -> np.ndarray:
    """(P, H, W) how strongly each zone sees each pixel's centre; the largest is 1."""
    return responses_at(maps, *pixel_places(maps, shape)) / unit_response(maps, shape)

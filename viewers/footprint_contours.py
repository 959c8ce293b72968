"""Where zones look, as lines over the camera's image."""

from collections.abc import Sequence

import cv2
import numpy as np

# Of each zone's largest weight: where it sees half as well as at best.
LEVEL = 0.5
# Combs of single diodes are finer than a line; of the image's width.
SMOOTHED = 0.012
# Contours shorter than this part of the image's width are specks.
SPECK = 0.06


def contours(weights: np.ndarray, size: tuple[int, int], level: float = LEVEL) -> list[np.ndarray]:
    """For each zone its longest contours at `level` of its largest weight.

    weights: (P, h, w) over the camera's field. size: (H, W) of the image to draw on. Returns P lists of closed lines
    (N, 2), x and y in pixels of that image counted from the corner of the first pixel, as the viewer counts them.
    """
    return [_of_zone(zone, size, level) for zone in weights]


def _of_zone(weights: np.ndarray, size: tuple[int, int], level: float) -> list[np.ndarray]:
    large = cv2.resize(np.ascontiguousarray(weights, np.float32), (size[1], size[0]), interpolation=cv2.INTER_LINEAR)
    smooth = cv2.GaussianBlur(large, (0, 0), max(SMOOTHED * size[1], 0.3), borderType=cv2.BORDER_REPLICATE)
    if not smooth.max() > 0:
        return []
    inside = (smooth >= level * smooth.max()).astype(np.uint8)
    found, _ = cv2.findContours(inside, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    closed = [np.concatenate([line, line[:1]])[:, 0] + 0.5 for line in found]
    return [line for line in closed if len(line) >= SPECK * size[1]]


def named(zones: Sequence[str]) -> list[str]:
    """Zones such as `1_2` as people write them."""
    return [zone.replace("_", ",") for zone in zones]

"""Bell-shaped spots in an image, by parts of its width and height."""

import numpy as np


def places(shape: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """(H, W) each: how far pixels are from the left and the upper edge, as parts of width and height."""
    below, right = np.indices(shape)
    return (right + 0.5) / shape[1], (below + 0.5) / shape[0]


def spot(shape: tuple[int, int], across: float, down: float, wide: float) -> np.ndarray:
    """(H, W), 1 at its centre. wide: standard deviation, as a part of the image's width."""
    right, below = places(shape)
    square = (right - across) ** 2 + ((below - down) * shape[0] / shape[1]) ** 2
    return np.exp(-0.5 * square / wide**2)

"""The part of the image a zone looks at: where its map reaches a stated fraction of its peak."""

from dataclasses import dataclass

import numpy as np

from calibrate.kernel import Kernel
from recordings.refusal import Refusal

STEP_PX = 2.0


@dataclass(frozen=True, eq=False)
class Supports:
    """Where P zones reach `threshold` of their peaks, on a grid over the scanned field.

    x_px, y_px: (W,), (H,) pixels of the grid. inside: (P, H, W). area_px2: (P,) pixels².
    """

    threshold: float
    x_px: np.ndarray
    y_px: np.ndarray
    inside: np.ndarray
    area_px2: np.ndarray


def supports(kernel: Kernel, threshold: float, step_px: float = STEP_PX) -> Supports:
    """Supports of the continuous maps, as a scan with this patch sees them, at `threshold` of each zone's peak."""
    if not 0 < threshold < 1:
        raise Refusal(f"threshold: {threshold} found, expected a fraction of the peak between 0 and 1")
    basis, margin = kernel.basis, kernel.patch_radius_px
    x = np.arange(basis.left_px + margin, basis.left_px + basis.columns * basis.step_px - margin, step_px)
    y = np.arange(basis.top_px + margin, basis.top_px + basis.rows * basis.step_px - margin, step_px)
    grid_x, grid_y = np.meshgrid(x, y)
    response = kernel.response(grid_x.ravel(), grid_y.ravel()).reshape(-1, len(y), len(x))
    peak = response.max(axis=(1, 2), keepdims=True)
    inside = (response >= threshold * peak) & (peak > 0)
    return Supports(threshold, x, y, inside, inside.sum(axis=(1, 2)) * step_px**2)

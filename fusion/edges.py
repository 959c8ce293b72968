"""Depth is smooth but for where colour changes: a Gaussian Markov random field on the camera's coarse grid."""

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from scipy.linalg import cho_solve_banded, cholesky_banded


@dataclass(frozen=True, eq=False)
class Field:
    """Precision A = L + ridge·1 of values at H × W pixels; L is the Laplacian of the grid with weighted edges.

    across: (H, W - 1) weights between a pixel and the next in its row; down: (H - 1, W), in its column.
    ridge: what pulls values to 0, everywhere alike or (H, W).
    """

    across: np.ndarray
    down: np.ndarray
    ridge: float | np.ndarray

    @property
    def shape(self) -> tuple[int, int]:
        """(H, W)."""
        return self.across.shape[0], self.down.shape[1]

    @cached_property
    def _order(self) -> str:
        # Along the shorter side, so that the band is narrow.
        return "F" if self.shape[0] <= self.shape[1] else "C"

    @cached_property
    def _factor(self) -> np.ndarray:
        """(band + 1, N) lower Cholesky factor in LAPACK's banded form."""
        height, width = self.shape
        near, far = (self.down, self.across) if self._order == "F" else (self.across, self.down)
        degree = np.full(self.shape, self.ridge, float)
        degree[:, 1:] += self.across
        degree[:, :-1] += self.across
        degree[1:] += self.down
        degree[:-1] += self.down
        band = min(height, width)
        table = np.zeros((band + 1, height * width))
        table[0] = degree.ravel(self._order)
        last = ((0, 1), (0, 0)) if self._order == "F" else ((0, 0), (0, 1))
        table[1] -= np.pad(near, last).ravel(self._order)
        # Where the grid is one pixel wide, the two coincide.
        table[band, : far.size] -= far.ravel(self._order)
        return cholesky_banded(table, lower=True, overwrite_ab=True, check_finite=False)

    def solve(self, images: np.ndarray) -> np.ndarray:
        """A⁻¹ of each image, (..., H, W)."""
        flat = images.reshape(-1, *self.shape)
        columns = np.stack([image.ravel(self._order) for image in flat], axis=1)
        found = cho_solve_banded((self._factor, True), columns, overwrite_b=True, check_finite=False)
        out = np.empty_like(flat, dtype=float)
        for image, column in zip(out, found.T, strict=True):
            image[:] = column.reshape(self.shape, order=self._order)
        return out.reshape(images.shape)


def guided_field(rgb: np.ndarray | None, shape: tuple[int, int], colour: float, left: float, ridge: float) -> Field:
    """The field on a grid of `shape` under the camera's image (any size, the same view), uint8; even where None.

    Weights are exp(-d²/2σ²) + left of the colour difference d with σ = colour, as for the bilateral filter (Tomasi &
    Manduchi 1998).
    """
    height, width = shape
    if rgb is None:
        return Field(np.ones((height, width - 1)), np.ones((height - 1, width)), ridge)
    small = cv2.resize(rgb, (width, height), interpolation=cv2.INTER_AREA)
    lab = cv2.cvtColor(small.astype(np.float32) / 255, cv2.COLOR_RGB2LAB) / 100
    across, down = (np.square(np.diff(lab, axis=axis)).sum(axis=-1).astype(float) for axis in (1, 0))
    return Field(*(np.exp(-square / (2 * colour**2)) + left for square in (across, down)), ridge)

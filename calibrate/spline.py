"""Tensor-product cubic B-splines over the image, at points and averaged over the patch."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.interpolate import BSpline

DEGREE = 3
RINGS, SPOKES = 3, 9  # quadrature on the disc: exact for polynomials up to degree 5


@dataclass(frozen=True)
class SplineBasis:
    """Uniform cubic B-splines on a grid of cells of `step_px` that begins at (left_px, top_px).

    columns, rows: number of cells. Coefficients are numbered with the row of splines running fastest, which keeps
    neighbours close together and the normal equations banded.
    """

    left_px: float
    top_px: float
    step_px: float
    columns: int
    rows: int

    @staticmethod
    def covering(x: np.ndarray, y: np.ndarray, margin_px: float, step_px: float) -> "SplineBasis":
        """The basis over the bounding box of the points (x, y) and a margin around it."""
        left, top = float(x.min() - margin_px), float(y.min() - margin_px)
        columns = int(np.ceil((x.max() + margin_px - left) / step_px))
        rows = int(np.ceil((y.max() + margin_px - top) / step_px))
        return SplineBasis(left, top, float(step_px), max(columns, 1), max(rows, 1))

    @property
    def shape(self) -> tuple[int, int]:
        """Number of splines along x and along y."""
        return self.columns + DEGREE, self.rows + DEGREE

    @property
    def size(self) -> int:
        """Number of coefficients."""
        return self.shape[0] * self.shape[1]

    def at(self, x: np.ndarray, y: np.ndarray) -> sparse.csr_array:
        """(N, size) values of every spline at N points, pixels; points outside take the nearest border value."""
        along_x = self._along(np.asarray(x, float).ravel(), self.left_px, self.columns)
        along_y = self._along(np.asarray(y, float).ravel(), self.top_px, self.rows)
        n = along_x.shape[0]
        # Each point sees 4 × 4 splines: the row-wise product of two sparse rows of four.
        index = along_x.indices.reshape(n, -1, 1) * self.shape[1] + along_y.indices.reshape(n, 1, -1)
        value = along_x.data.reshape(n, -1, 1) * along_y.data.reshape(n, 1, -1)
        start = np.arange(n + 1) * value[0].size if n else np.zeros(1, int)
        return sparse.csr_array((value.ravel(), index.ravel(), start), shape=(n, self.size))

    def covers(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """(N,) whether points lie in the field the splines span."""
        right, bottom = self.left_px + self.columns * self.step_px, self.top_px + self.rows * self.step_px
        return (x >= self.left_px) & (x <= right) & (y >= self.top_px) & (y <= bottom)

    def over_disc(self, x: np.ndarray, y: np.ndarray, radius_px: float) -> sparse.csr_array:
        """(N, size) mean of every spline over discs of `radius_px` around N points."""
        offsets, weights = disc_quadrature(radius_px)
        parts = (
            weight * self.at(np.asarray(x) + dx, np.asarray(y) + dy)
            for (dx, dy), weight in zip(offsets, weights, strict=True)
        )
        total = next(parts)
        for part in parts:
            total = total + part
        return total

    def _along(self, position: np.ndarray, origin: float, cells: int) -> sparse.csr_array:
        knots = origin + self.step_px * np.arange(-DEGREE, cells + DEGREE + 1)
        inside = np.clip(position, knots[DEGREE], knots[DEGREE + cells])
        return sparse.csr_array(BSpline.design_matrix(inside, knots, DEGREE))

    def roughness(self) -> sparse.csr_array:
        """(size, size) penalty on the differences of neighbouring coefficients along x and y (a membrane)."""
        along_x, along_y = (_differences(n) for n in self.shape)
        eye_x, eye_y = (sparse.eye_array(n) for n in self.shape)
        return sparse.csr_array(sparse.kron(along_x, eye_y) + sparse.kron(eye_x, along_y))


def _differences(n: int) -> sparse.csr_array:
    """DᵀD of the differences between n neighbours."""
    d = sparse.csr_array(np.diff(np.eye(n), axis=0))
    return sparse.csr_array(d.T @ d)


def disc_quadrature(radius_px: float) -> tuple[np.ndarray, np.ndarray]:
    """Offsets (N, 2) and weights (N,), summing to 1, that average a smooth function over a disc.

    Gauss-Legendre in the squared radius, equal angles around (Stroud 1971, product rules for the disc). A radius of 0
    gives the centre alone.
    """
    if radius_px == 0:
        return np.zeros((1, 2)), np.ones(1)
    node, weight = np.polynomial.legendre.leggauss(RINGS)
    ring = radius_px * np.sqrt((node + 1) / 2)
    angle = 2 * np.pi * np.arange(SPOKES) / SPOKES
    offsets = np.stack([np.outer(ring, np.cos(angle)).ravel(), np.outer(ring, np.sin(angle)).ravel()], axis=1)
    return offsets, np.repeat(weight / 2, SPOKES) / SPOKES

"""Where in the image each cell of the scan's grid lies: a plane seen through a lens, fitted to uncertain sightings."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

SEEDS = 1000
# A sighting belongs to the grid within these shares of the image's width: of a plane guessed from three sightings,
# and of the fitted model, which robots and lenses leave by a dozen pixels in 848.
ROUGH, FINE = 0.04, 0.02
SAME_RADIUS = 0.15
SPAN_PX = 3.0  # The middle four fifths of the sightings of something that moves differ by more than this.
LEAST, LEAST_SHARE = 8, 0.1
MOST = 0.7  # of the cells where a disc of this radius is seen must agree with the grid.
ROUNDS = 6
# Perspective and distortion are slight; so much of either counts as an error of a pixel.
SLIGHT = 0.5, 0.5, 0.2


@dataclass(frozen=True)
class Sightings:
    """N discs seen at cells of the grid, perhaps several at one cell, perhaps none of them the patch.

    cell: (N, 2) column and row. at_px: (N, 2). radius_px: (N,). confidence: (N,) 0 to 1.
    """

    cell: np.ndarray
    at_px: np.ndarray
    radius_px: np.ndarray
    confidence: np.ndarray


@dataclass(frozen=True)
class GridModel:
    """Projective map from cells to pixels, then radial distortion about the image's centre.

    parameters: (9,) eight of the homography from cells scaled to -1..1 to half-diagonals from the image's centre,
    and the distortion per squared half-diagonal. shape: columns, rows. size: width, height of the image.
    scatter_px: robust standard deviation of the sightings about the model, along one axis.
    """

    parameters: np.ndarray
    shape: tuple[int, int]
    size: tuple[int, int]
    scatter_px: float

    def predict(self, cells: np.ndarray) -> np.ndarray:
        """(..., 2) pixels of cells (..., 2), column and row."""
        return _project(self.parameters, _scaled(cells, self.shape), self.size)


def fit_grid(
    seen: Sightings, cells: int, shape: tuple[int, int], size: tuple[int, int], rng: np.random.Generator
) -> tuple[GridModel, np.ndarray] | None:
    """Fit the grid and say which sightings (N,) bool belong to it; None where none explains enough of them.

    cells: how many were looked at. The grid's orientation is free. Planes through three sightings of about the same
    radius (RANSAC; Fischler & Bolles 1981) compete by the confidence of what they explain; a disc that stands still
    explains no grid, however often it is seen. The winner grows into the full model.
    """
    least = max(3, min(LEAST, (cells + 1) // 2), LEAST_SHARE * cells)
    place = _scaled(seen.cell, shape)
    start = _plane(seen, place, ROUGH * size[0], least, rng)
    if start is None:
        return None
    plane, inlier, radius = start
    half = np.hypot(*size) / 2
    parameters = np.zeros(9)
    parameters[:6] = (plane - np.outer([0, 0, 1], _centre(size))).T.ravel() / half
    alike = _alike(seen.radius_px, radius)
    for _ in range(ROUNDS):
        fit = least_squares(_residuals, parameters, args=(place[inlier], seen.at_px[inlier], size), loss="soft_l1")
        parameters = fit.x
        error = seen.at_px - _project(parameters, place, size)
        near = alike & (np.hypot(*error.T) < FINE * size[0])
        if len(np.unique(seen.cell[near], axis=0)) < max(least, MOST * len(np.unique(seen.cell[alike], axis=0))):
            return None
        if (near == inlier).all():
            break
        inlier = near
    scatter = 1.4826 * float(np.median(np.abs(error[inlier])))
    return GridModel(parameters, shape, size, scatter), inlier


def _plane(
    seen: Sightings, place: np.ndarray, tolerance_px: float, least: float, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, float] | None:
    """The affine map (3, 2) from (u, v, 1) to pixels that explains most, the sightings it explains, their radius."""
    count = len(seen.radius_px)
    if count < least:
        return None
    design = np.column_stack([place, np.ones(count)])
    triples = rng.choice(count, (SEEDS, 3), p=seen.confidence / seen.confidence.sum())
    radii = seen.radius_px[triples]
    triples = triples[_alike(radii, radii[:, :1]).all(axis=1)]
    radii = np.median(seen.radius_px[triples], axis=1)
    planes = np.linalg.pinv(design[triples]) @ seen.at_px[triples]
    distance = np.linalg.norm(design @ planes - seen.at_px, axis=-1)
    explained = (distance < tolerance_px) & _alike(seen.radius_px, radii[:, None])
    for best in np.argsort(-(explained @ seen.confidence), kind="stable"):
        inlier = explained[best]
        if len(np.unique(seen.cell[inlier], axis=0)) < least:
            return None
        if np.ptp(np.quantile(seen.at_px[inlier], [0.1, 0.9], axis=0), axis=0).max() > SPAN_PX:
            return planes[best], inlier, float(radii[best])
    return None


def _alike(radius_px: np.ndarray, other_px: np.ndarray | float) -> np.ndarray:
    return np.abs(np.log(radius_px / other_px)) < SAME_RADIUS


def _scaled(cells: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Columns and rows mapped to -1..1; a single column or row to 0."""
    last = np.array(shape) - 1
    return (2 * np.asarray(cells) - last) / np.maximum(last, 1)


def _centre(size: tuple[int, int]) -> np.ndarray:
    return (np.array(size) - 1) / 2


def _project(parameters: np.ndarray, place: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Pixels (..., 2) of scaled cells (..., 2)."""
    homography = np.append(parameters[:8], 1).reshape(3, 3)
    seen = place @ homography[:, :2].T + homography[:, 2]
    flat = seen[..., :2] / np.maximum(seen[..., 2:], 0.05)
    bent = flat * (1 + parameters[8] * np.square(flat).sum(axis=-1, keepdims=True))
    return bent * (np.hypot(*size) / 2) + _centre(size)


def _residuals(parameters: np.ndarray, place: np.ndarray, at_px: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Errors in pixels, and the parameters that should be slight."""
    return np.append((_project(parameters, place, size) - at_px).ravel(), parameters[6:] / SLIGHT)

"""A continuous kernel through the samples of a scan: the response at any image point, with its error."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from calibrate.banded import Penalised, solve
from calibrate.spline import SplineBasis
from recordings.maps import ResponseMaps
from recordings.refusal import Refusal

PUBLISHED_RADIUS_PX = 17.75  # what the published scan's patch was looked for with
STEP_OF_RADIUS = 0.6  # knots this fraction of the patch radius apart: finer structure is blurred away by the patch
MOST_SPLINES = 12_000
NEIGHBOURS = 8
OUTLIER = 6.0  # standard errors between a sample and what its neighbours predict
CLASS = 20  # samples, at least, in a class of brightness whose scatter is measured
BRIGHT_SHARE = 0.15  # of the samples, the brightest, are divided as finely as all others together: a zone looks at
# a small part of the image, and that part is what matters
ONE_SIGMA = 0.6827


@dataclass(frozen=True, eq=False)
class Kernel:
    """Responses of P zones over the image as cubic splines, fitted to the samples of a patch scan.

    A sample is the mean of the kernel over the patch's disc, so that the kernel itself is freed of the patch's size.

    coefficients: (P, M). patch_radius_px: the disc that was deconvolved. scatter: per zone, standard deviation of
    a sample around the fit as a function of the response there, counts. outliers: (P, K) samples that depart from
    what all others predict by more than six standard errors, and from their neighbours; they took no part.
    """

    basis: SplineBasis
    posterior: Penalised
    coefficients: np.ndarray
    patch_radius_px: float
    scatter: tuple[Callable[[np.ndarray], np.ndarray], ...]
    outliers: np.ndarray

    def density(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """(P, N) response per patch area at N image points: the map freed of the patch's size, counts."""
        return np.maximum(self.coefficients @ self.basis.at(x, y).T, 0)

    def response(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """(P, N) what a scan with this patch would measure at N image points, counts."""
        return np.maximum(self.coefficients @ self.basis.over_disc(x, y, self.patch_radius_px).T, 0)

    def density_sigma(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """(P, N) standard error of `density`, counts."""
        return self._sigma(self.basis.at(x, y), x, y)

    def response_sigma(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """(P, N) standard error of `response`, counts."""
        return self._sigma(self.basis.over_disc(x, y, self.patch_radius_px), x, y)

    def _sigma(self, rows, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        # The posterior assumes equal noise everywhere; the scatter that the data show grows with the response.
        unit = np.sqrt(self.posterior.variance(rows))
        return np.stack([s(level) for s, level in zip(self.scatter, self.response(x, y), strict=True)]) * unit


def fit_kernel(maps: ResponseMaps, patch_radius_px: float, captures: np.ndarray | None = None) -> Kernel:
    """Fit the kernel to the samples of `maps`, or to some of its captures only.

    patch_radius_px: radius of the patch in the full-size image, pixels; 0 where its size is not to be deconvolved.
    A zone that never responds has the kernel 0. Raises `Refusal` where none responds, or for fewer than 10 samples.
    """
    if not (np.isfinite(patch_radius_px) and patch_radius_px >= 0):
        raise Refusal(f"patch radius: {patch_radius_px} px found, expected pixels of 0 or more")
    captures = np.arange(len(maps.xs)) if captures is None else captures
    x, y = maps.xs[captures].astype(float), maps.ys[captures].astype(float)
    samples = maps.by_zone[:, captures].astype(float)
    if len(x) < 10:
        raise Refusal(f"xs: {len(x)} scan positions, expected at least 10 to fit a kernel to")
    peaks = samples.max(axis=1, keepdims=True)
    alive = peaks[:, 0] > 0
    if not alive.any():
        raise Refusal("responses: all are 0, expected zones that respond somewhere")

    basis = SplineBasis.covering(x, y, patch_radius_px, _step(x, y, patch_radius_px))
    design = basis.over_disc(x, y, patch_radius_px)
    posterior = solve(design, basis.roughness(), samples[alive] / peaks[alive])

    coefficients = posterior.coefficients(samples)
    fitted = (design @ coefficients.T).T
    # Replacing a datum by what all others predict gives the fit without it.
    left_out = samples - (samples - fitted) / (1 - posterior.leverage)
    standardised = (samples - fitted) / np.sqrt(1 - posterior.leverage)
    scatter = tuple(_scatter(left_out[p], standardised[p]) for p in range(len(samples)))
    noise = np.stack([s(level) for s, level in zip(scatter, left_out, strict=True)])
    outliers = (np.abs(standardised) > OUTLIER * noise) & _beyond_neighbours(x, y, samples)
    if outliers.any():
        coefficients = posterior.coefficients(np.where(outliers, left_out, samples))
    return Kernel(basis, posterior, coefficients, float(patch_radius_px), scatter, outliers)


def patch_radius_of(maps: ResponseMaps) -> float:
    """Radius of the patch that the maps were scanned with, pixels; published files do not carry it."""
    return float(maps.meta.get("patch_radius_px", PUBLISHED_RADIUS_PX))


def _beyond_neighbours(x: np.ndarray, y: np.ndarray, samples: np.ndarray) -> np.ndarray:
    """(P, K) samples further outside the range of their nearest neighbours than that range is wide.

    Where a scan is coarser than the map's own structure, prediction fails without anything being wrong.
    """
    _, near = cKDTree(np.stack([x, y], axis=1)).query(np.stack([x, y], axis=1), min(NEIGHBOURS + 1, len(x)))
    around = samples[:, near[:, 1:]]
    low, high = around.min(axis=2), around.max(axis=2)
    return (samples > high + (high - low)) | (samples < low - (high - low))


def _step(x: np.ndarray, y: np.ndarray, patch_radius_px: float) -> float:
    """Knot spacing: fine enough for what the patch can resolve, bounded in number for very large images."""
    width, height = np.ptp(x), np.ptp(y)
    nearest = cKDTree(np.stack([x, y], axis=1)).query(np.stack([x, y], axis=1), 2)[0][:, 1]
    wanted = STEP_OF_RADIUS * patch_radius_px if patch_radius_px else float(np.median(nearest))
    finest = max(np.sqrt(width * height / MOST_SPLINES), (width + height) / np.sqrt(MOST_SPLINES) / 10, 1e-3)
    return float(max(wanted, finest))


def _scatter(level: np.ndarray, residual: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """Standard deviation of the residuals as a non-decreasing function of the level, from classes of samples.

    The 68 % quantile of a class is used for its standard deviation: single wild samples do not move it.
    """
    order = np.argsort(level)
    bright = int(len(order) * (1 - BRIGHT_SHARE))
    classes = [part for half in (order[:bright], order[bright:]) for part in _classes(half)]
    at = np.array([np.median(level[c]) for c in classes])
    spread = np.array([np.quantile(np.abs(residual[c]), ONE_SIGMA) for c in classes])
    spread = np.maximum.accumulate(np.maximum(spread, 1e-12 * max(level.max(), 1)))
    return lambda response: np.interp(response, at, spread)


def _classes(order: np.ndarray) -> list[np.ndarray]:
    return np.array_split(order, min(max(len(order) // CLASS, 1), 12))

"""The first guess at where a sensor looks, from a few samples all over the image."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from calibrate.adaptive_model import FLOOD_STEP, Model
from calibrate.adaptive_optics import SIZE, SPREAD, SpadOptics
from calibrate.spline import SplineBasis
from physics.flood import tmf882x_flood
from physics.optics import Optics
from physics.spads import spad_map
from recordings.refusal import Refusal

# SPAD maps whose layout is known, by rows and columns of zones.
LAYOUTS = {(3, 3): (6, 1), (4, 4): (7, 13), (6, 3): (10,)}
SIZES = (0.7, 1.0)  # of the field, tried: the centres of zones are farther apart than coarse samples say
STIFFNESS = 0.05  # a parameter one standard deviation off costs as much as this share of a peak
SOFT = 0.1  # of the peak: residuals beyond count less than their square
EVALUATIONS = 40


@dataclass(frozen=True, eq=False)
class Start:
    """A model and its most probable unknowns (M,); cost: misfit left."""

    model: Model
    unknown: np.ndarray
    cost: float


def improved(start: Start, xy: np.ndarray, seen: np.ndarray) -> Start:
    """The same fitted anew, to more samples."""
    return _fitted(start.model, start.unknown[:SIZE], xy, seen)


def first_guess(
    zone_grid: tuple[int, int], field_px: np.ndarray, radius_px: float, xy: np.ndarray, seen: np.ndarray
) -> Start:
    """Fit the optics of each SPAD map of this grid to samples (P, n) at (n, 2), in units of each zone's peak.

    field_px: (K, 2) all positions. Raises `Refusal` where no SPAD map with this grid is known or a zone saw nothing.
    """
    known(zone_grid)
    if dark := np.flatnonzero(seen.max(axis=1) <= 0).tolist():
        raise Refusal(f"adaptive scan: zones {dark} saw nothing of the patch, expected all to see it somewhere")
    centre, scale = field_px.mean(axis=0), float(np.hypot(*field_px.std(axis=0)))
    flood = SplineBasis.covering(*field_px.T, radius_px, FLOOD_STEP * radius_px)
    found = []
    for layout in LAYOUTS[zone_grid]:
        optics = SpadOptics(spad_map(layout), centre, scale, radius_px)
        model = Model(optics, flood, len(seen))
        found += [_fitted(model, _placed(optics, xy, seen, size), xy, seen) for size in SIZES]
    return min(found, key=lambda start: start.cost)


def known(zone_grid: tuple[int, int]) -> None:
    """Refuse a grid of zones whose SPADs are not known."""
    if tuple(zone_grid) not in LAYOUTS:
        grids = ", ".join(f"{rows} x {columns}" for rows, columns in LAYOUTS)
        rows, columns = zone_grid
        raise Refusal(f"adaptive scan: {rows} x {columns} zones, expected one of {grids}, whose SPADs are known")


def _placed(optics: SpadOptics, xy: np.ndarray, seen: np.ndarray, size: float) -> np.ndarray:
    """(18,) nominal parameters, the geometry an affine map of the zones' centroids; it knows of turns and mirrors."""
    tangents = np.stack(np.meshgrid(*[np.linspace(-0.6, 0.6, 60)] * 2), axis=-1).reshape(-1, 2)
    nominal = Optics(optics.spads, tmf882x_flood()).response(np.column_stack([tangents, np.ones(len(tangents))]))
    there = nominal @ tangents / nominal.sum(axis=1, keepdims=True)
    here = (seen @ xy / seen.sum(axis=1, keepdims=True) - optics.centre_px) / optics.scale_px
    middle = here.mean(axis=0)
    affine = np.linalg.lstsq(np.column_stack([np.ones(len(here)), here - middle]), there, rcond=None)[0]
    values = optics.nominal()
    for i in (0, 1):
        slope = affine[1:, i] * size
        values[3 * i : 3 * i + 3] = [affine[0, i] - slope @ middle, *slope]
    return values


def _fitted(model: Model, values: np.ndarray, xy: np.ndarray, seen: np.ndarray) -> Start:
    """Least squares in the optics' parameters and the gains."""
    optics, zones = model.optics, len(seen)
    weights = np.zeros(optics.mixing.shape[1])
    pull = np.diag(STIFFNESS / SPREAD)

    def residuals(v: np.ndarray) -> np.ndarray:
        maps = np.exp(v[SIZE:])[:, None] * optics.maps(np.concatenate([v[:SIZE], weights]), *xy.T)
        return np.concatenate([(maps - seen).ravel(), pull @ (v[:SIZE] - values)])

    def slopes(v: np.ndarray) -> np.ndarray:
        base, by_value = optics.derivatives(np.concatenate([v[:SIZE], weights]), *xy.T)
        gain = np.exp(v[SIZE:])[:, None]
        by_gain = np.einsum("pq,pn->pqn", np.eye(zones), gain * base)
        of_samples = np.concatenate([by_value * gain, by_gain]).reshape(SIZE + zones, -1).T
        return np.vstack([of_samples, np.hstack([pull, np.zeros((SIZE, zones))])])

    # A patch on the SPADs of one zone alone, in the middle of the flood, fills about a third of them.
    first = np.concatenate([values, np.log(3 * seen.max(axis=1))])
    best = least_squares(residuals, first, slopes, loss="soft_l1", f_scale=SOFT, max_nfev=EVALUATIONS)
    return Start(model, model.nominal(best.x[:SIZE], np.exp(best.x[SIZE:])), float(best.cost))

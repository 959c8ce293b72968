"""The most probable unknowns of the model of the optics, and how strongly maps depart from it."""

import numpy as np
from scipy.linalg import solve_triangular

from calibrate.adaptive_kernel import REACH, departures, noise, solved
from calibrate.adaptive_model import SEEN, Model, Rows
from calibrate.adaptive_posterior import Posterior
from calibrate.banded import one_thread

DEPARTURE = (0.1, 0.05)  # to begin with: of the flood's texture, common to the zones, and of each zone
STRENGTHS = (0.01, 0.5)
STRENGTH_STEP = 1.5
STRENGTH_SPREAD = 0.2  # of their logarithms: a few samples tell little of them
ROUNDS = 3
SHORTER, SHORTEST = 0.4, 0.005  # of a step


def fit(
    model: Model,
    prior: np.ndarray,
    unknown: np.ndarray,
    strengths: tuple[float, float] | None,
    xy: np.ndarray,
    seen: np.ndarray,
    sigma: np.ndarray,
    rounds: int = ROUNDS,
) -> Posterior:
    """Gauss-Newton from `unknown`; the strengths of the departures move a step towards larger evidence."""
    spread, reach = model.spread**2, REACH * model.optics.radius_px
    strengths = strengths or DEPARTURE
    for turn in range(rounds + 1):
        kept = (model.maps(unknown, *xy.T)[1] > SEEN) | (seen > 3 * SEEN)
        rows = model.rows(unknown, *xy.T, kept)
        linear = ((rows.slope * spread) @ rows.slope.T).toarray()
        own = np.diag(noise(rows, seen, sigma))
        residual = seen[kept] - rows.value
        shifted = residual + rows.slope @ (unknown - prior)
        if turn == rounds:
            strengths = _stronger(linear + own, rows, xy, reach, shifted, strengths)
        apart = own + departures(rows, rows, xy, xy, strengths, reach)
        factor, lever, _ = solved(linear + apart, shifted)
        pull = solved(apart, residual)[1]
        if turn == rounds:
            break
        step = prior + spread * (rows.slope.T @ lever) - unknown
        unknown = _downhill(model, prior, unknown, step, xy, seen, kept, apart)
    return Posterior(model, prior, unknown, strengths, xy, seen, sigma, rows, factor, lever, pull)


def _downhill(
    model: Model,
    prior: np.ndarray,
    unknown: np.ndarray,
    step: np.ndarray,
    xy: np.ndarray,
    seen: np.ndarray,
    kept: np.ndarray,
    apart: np.ndarray,
) -> np.ndarray:
    """The unknowns a step further, shortened until they are more probable than before, departures marginalised."""
    with one_thread():
        factor = np.linalg.cholesky(apart)

    def cost(there):
        residual = seen[kept] - model.maps(there, *xy.T)[0][kept]
        half = solve_triangular(factor, residual, lower=True, check_finite=False)
        return half @ half + np.square((there - prior) / model.spread).sum()

    here, share = cost(unknown), 1.0
    while share > SHORTEST:
        there = unknown + share * step
        if cost(there) < here:
            return there
        share *= SHORTER
    return unknown


def _stronger(
    linear: np.ndarray, rows: Rows, xy: np.ndarray, reach: float, residual: np.ndarray, strengths: tuple[float, float]
) -> tuple[float, float]:
    """The strengths, or neighbours of theirs under which the samples are more probable."""

    def evidence(pair):
        doubt = np.square(np.log(np.divide(pair, DEPARTURE)) / STRENGTH_SPREAD).sum() / 2
        return solved(linear + departures(rows, rows, xy, xy, pair, reach), residual)[2] - doubt

    best, found = strengths, evidence(strengths)
    for i in (0, 1):
        for factor in (STRENGTH_STEP, 1 / STRENGTH_STEP):
            other = list(best)
            other[i] = float(np.clip(best[i] * factor, *STRENGTHS))
            if (there := evidence(tuple(other))) > found:
                best, found = tuple(other), there
                break
    return best

"""The most probable unknowns of the model of the optics, and how strongly maps depart from it."""

import numpy as np
from scipy.linalg import cho_solve, solve_triangular

from calibrate.adaptive_kernel import DOUBT, LEAST, MOST, REACH, STRENGTHS, alone_noise, departures, shared, solved
from calibrate.adaptive_model import SEEN, Model
from calibrate.adaptive_posterior import Posterior
from calibrate.banded import one_thread

STRENGTH_STEP = 1.5
ROUNDS = 3
SHORTER, SHORTEST = 0.4, 0.005  # of a step


def fit(
    model: Model,
    prior: np.ndarray,
    unknown: np.ndarray,
    strengths: np.ndarray | None,
    xy: np.ndarray,
    seen: np.ndarray,
    sigma: np.ndarray,
    rounds: int = ROUNDS,
) -> Posterior:
    """Gauss-Newton from `unknown`; the strengths of departures and shared errors move a step to larger evidence."""
    spread, reach = model.spread**2, REACH * model.optics.radius_px
    strengths = np.array(STRENGTHS) if strengths is None else strengths
    for turn in range(rounds + 1):
        kept = (model.maps(unknown, *xy.T)[1] > SEEN) | (seen > 3 * SEEN)
        rows = model.rows(unknown, *xy.T, kept)
        linear = ((rows.slope * spread) @ rows.slope.T).toarray()
        alone = alone_noise(rows.value, seen[kept], sigma[kept])
        parts = (*departures(rows, rows, xy, xy, reach), *shared(rows, model.optics.radius_px))
        residual = seen[kept] - rows.value
        shifted = residual + rows.slope @ (unknown - prior)
        if turn == rounds:
            strengths = _stronger(linear + np.diag(alone), parts, shifted, strengths)
        apart = _with(np.diag(alone), parts, strengths)
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


def _with(fixed: np.ndarray, parts: tuple, strengths: np.ndarray) -> np.ndarray:
    return fixed + sum(s**2 * part for s, part in zip(strengths, parts, strict=True))


def _stronger(fixed: np.ndarray, parts: tuple, residual: np.ndarray, strengths: np.ndarray) -> np.ndarray:
    """The strengths a step towards those under which the samples are more probable, all at once.

    The slope of the evidence by their logarithms (Rasmussen & Williams 2006, Eq. 5.9), with a log-normal prior; the
    step is bounded, as the curvature is only guessed: twice what the part explains of the samples' variance.
    """
    factor, lever, _ = solved(_with(fixed, parts, strengths), residual)
    with one_thread():
        inverse = cho_solve((factor, True), np.eye(len(factor)), check_finite=False)
    explained = strengths**2 * [np.vdot(inverse, part) for part in parts]
    found = strengths**2 * [lever @ part @ lever for part in parts]
    slope = found - explained - np.log(strengths / STRENGTHS) / np.square(DOUBT)
    step = slope / (2 * explained + 1 / np.square(DOUBT))
    return np.clip(strengths * np.exp(np.clip(step, *np.log([1 / STRENGTH_STEP, STRENGTH_STEP]))), LEAST, MOST)

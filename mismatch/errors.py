"""Errors of fitted coordinates: curvature of the likelihood, and how far it really falls where that is not constant."""

from collections.abc import Callable

import numpy as np

from mismatch.form import Form
from mismatch.steps import limits
from recordings.refusal import Refusal

# Of the gain's information what is left beside effects that can do the same.
NOTHING_LEFT = 1e-6
# How near to its rise at one standard deviation, which is 1, is near enough to go by the square from there.
NEAR = 0.3
MOST_TRIES = 5
STRETCH = 3.0
TINY = 1e-12

# Deviance at coordinates less that of the best: with the others as they are, or at their best beside one that is held.
Rise = Callable[[np.ndarray, int | None], float]


def covariance(forms: tuple[Form, ...], x: np.ndarray, information: np.ndarray, rise: Rise) -> np.ndarray:
    """(N, N) covariance of coordinates (N,), log gain first.

    The inverse of the information (N, N); what the data do not tell is as uncertain as its bounds are wide. Where
    effects can make the gain's change exactly, only their ratio to it can be known, and the gain is held. Where the
    deviance does not rise with the square, errors of parameters that are one number for all are stretched to where it
    has risen by 1, the others at their best (likelihood-based intervals: Venzon and Moolgavkar 1988). Those of each
    zone or bin take part in that as they are correlated with them.
    """
    low, high = limits(forms)
    prior = np.zeros(len(x))
    prior[1:] = 1 / (high - low)[1:] ** 2
    curvature = information + np.diag(prior)
    inner = np.linalg.pinv(curvature[1:, 1:], hermitian=True)
    mixed = curvature[0, 1:]
    if curvature[0, 0] - mixed @ inner @ mixed > NOTHING_LEFT * curvature[0, 0]:
        found = np.linalg.pinv(curvature, hermitian=True)
    else:
        found = np.zeros_like(curvature)
        found[1:, 1:] = inner
    stretch = np.ones(len(x))
    places = [place for form in forms for _, place in form.coordinates]
    for i, place in enumerate(places, start=1):
        if place is None and found[i, i] > 0:
            stretch[i] = _reach(x, found[:, i] / np.sqrt(found[i, i]), i, (low, high), rise)
    wider = found * np.outer(stretch, stretch)
    # Numbers of each zone or bin go along with those that are one for all, as far as these have been stretched.
    for i in np.flatnonzero(stretch > 1):
        along = np.where([place is not None for place in (None, *places)], found[:, i], 0)
        wider += (stretch[i] ** 2 - 1) * np.outer(along, along) / found[i, i]
    return wider


def _reach(x: np.ndarray, way: np.ndarray, i: int, ends: tuple[np.ndarray, np.ndarray], rise: Rise) -> float:
    """How many times `way` coordinate i has gone where the deviance has risen by 1.

    Mean of both sides; the farther where a bound cuts one, or a plateau would be taken for its edge.
    """
    low, high = ends
    whole, cut = [], []
    for side in (-1.0, 1.0):
        room = ((high[i] - x[i]) if side * way[i] > 0 else (x[i] - low[i])) / abs(way[i])
        times, risen = _risen(x, side * way, i, room, ends, rise)
        (whole if risen else cut).append(times)
    return max(cut + whole) if cut else float(np.mean(whole))


def _risen(x: np.ndarray, way: np.ndarray, i: int, room: float, ends, rise: Rise) -> tuple[float, bool]:
    """The multiple of `way`, `room` at most, at which the deviance has risen by 1, and whether it has."""
    if room <= 0:
        return 0.0, False
    times = min(1.0, room)
    try:
        if abs(rise(np.clip(x + times * way, *ends), None) - times**2) < NEAR:
            return times, room > 1
        short, far = 0.0, np.inf
        for _ in range(MOST_TRIES):
            risen = rise(np.clip(x + times * way, *ends), i)
            if abs(risen - 1) < NEAR:
                return min(times / np.sqrt(risen), room), True
            if times == room and risen < 1:
                return room, False
            short, far = (times, far) if risen < 1 else (short, times)
            next_ = min(times * float(np.clip(np.sqrt(1 / max(risen, TINY)), 1 / STRETCH, STRETCH)), room)
            times = next_ if short < next_ < far or not short else float(np.sqrt(short * far))
    except Refusal:  # Counts that cannot be are as good as a bound.
        return times, False
    return times, True

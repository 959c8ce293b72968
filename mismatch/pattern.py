"""Numbers of all bins, or patches, many and each of them small: drawn from one distribution, whose width the data tell.

Each bin's number fitted by itself follows noise as well as what is there; it predicts other frames worse the weaker the
pattern is, until it predicts nothing that is seen in the sum of them all. Taken as drawn from a normal distribution
about nothing they are shrunk towards it by as much as noise has widened them (James and Stein 1961; the width by
maximum likelihood, the numbers integrated out: Morris 1983, J. Am. Stat. Assoc. 78, 47). Edges of bins are drawn each
by itself, as where a delay line's taps are off, or their distances are, as where bins are unequally wide: then an edge
lies where the widths before it end, and the edges walk. The likelier of the two is taken. Of a likelihood that is
normal about its best, of information I and precision Λ of the distribution, all of this is linear.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from mismatch.coordinate import to_coordinate
from mismatch.drawn_width import likeliest_width
from mismatch.form import DRAWN, Form

# Numbers of these may walk; of many of those a recording may tell nothing, so that a fit holds them until it is known
# how they are drawn, by a normal distribution of so many starts.
EDGES, PATCH = ("edge", "zone edge"), "patch"
HELD = 5.0


@dataclass(frozen=True, eq=False)
class Pattern:
    """What is known of numbers that are drawn.

    which: (K,) coordinates. nothing: (K,) where they are nothing. width: of their distribution, or of that of their
    distances. precision: (K, K) inverse of its covariance. cost: deviance that the numbers must gain, Schwarz's price
    of single ones in other places. effective: how many numbers they are worth.
    """

    which: np.ndarray
    nothing: np.ndarray
    width: float
    precision: np.ndarray
    cost: float
    effective: float

    def unlikely(self, x: np.ndarray) -> float:
        """Twice the logarithm by which numbers of N coordinates are less likely than nothing is."""
        away = x[self.which] - self.nothing
        return float(away @ self.precision @ away)

    def prior(self, count: int) -> np.ndarray:
        """(N, N) precision of N coordinates."""
        out = np.zeros((count, count))
        out[np.ix_(self.which, self.which)] = self.precision
        return out


def drawn(forms: tuple[Form, ...]) -> np.ndarray:
    """(K,) coordinates, log gain first, that are numbers of each bin or edge."""
    each = [p for form in forms for p in form.coordinates]
    return np.array([i for i, (p, place) in enumerate(each, 1) if place is not None and p.axis in DRAWN], int)


def held(forms: tuple[Form, ...]) -> np.ndarray:
    """(N,) precision by which a fit holds coordinates at nothing, which is at 0 for those that it holds."""
    each = [p for form in forms for p in form.coordinates]
    return np.array([0.0, *((place is not None and p.axis == PATCH) / HELD**2 for p, place in each)])


def shrunk(forms: tuple[Form, ...], x: np.ndarray, information: np.ndarray) -> tuple[np.ndarray, Pattern]:
    """(N,) coordinates as likely as can be under numbers that are drawn, from the best x of all, and their pattern.

    Best as far as they are `held`, with a likelihood that rises by that much. information: (N, N) there.
    """
    which = drawn(forms)
    rest = np.setdiff1d(np.arange(len(x)), which)
    parameters = [p for form in forms for p, _ in form.coordinates]
    nothing = np.array([to_coordinate(parameters[i - 1], parameters[i - 1].vanishes_at) for i in which])
    mixed = information[np.ix_(which, rest)]
    inner = information[np.ix_(rest, rest)]
    alone = information[np.ix_(which, which)] - mixed @ np.linalg.pinv(inner, hermitian=True) @ mixed.T
    away = x[which] - nothing
    rises = held(forms)[which] * away
    score = alone @ away + rises
    found = ((*likeliest_width(*_of_steps(alone, score, walks)), walks) for walks in _ways(forms))
    _, square, told, walks = min(found, key=lambda one: one[0])
    precision = _precision(len(which), walks) / square
    pull = np.zeros(len(x))
    pull[which] = precision @ away - rises
    wider = 1 + square * told
    worth, price = float((square * told / wider).sum()), float(np.log(wider).sum())
    pattern = Pattern(which, nothing, float(np.sqrt(square)), precision, price, worth)
    there = x - _solved(information + pattern.prior(len(x)), pull, which, rest)
    return there, replace(pattern, cost=price + pattern.unlikely(there))


def _ways(forms: tuple[Form, ...]) -> list[tuple[slice, ...]]:
    """Which of the numbers may walk together, those of each zone's edges: none, or all of these."""
    walks, at = [], 0
    for form in forms:
        for name in form.own:
            axis, count, bins = form.effect.parameter(name).axis, form.sizes[name], form.sizes["bin"]
            if axis in EDGES:
                walks += [slice(start, start + bins) for start in range(at, at + count, bins)]
            at += count if axis in DRAWN else 0
    return [(), tuple(walks)] if walks else [()]


def _of_steps(information: np.ndarray, score: np.ndarray, walks: tuple[slice, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Information (K, K) and score (K,) of the steps of walks: a step counts in all numbers from its own on."""
    information, score = information.copy(), score.copy()
    for of in (information, information.T, score):
        for walk in walks:
            of[walk] = np.cumsum(of[walk][::-1], axis=0)[::-1]
    return information, score


def _precision(count: int, walks: tuple[slice, ...]) -> np.ndarray:
    """(K, K) inverse covariance of numbers whose steps are drawn with width 1, each by itself where none walk."""
    precision = np.eye(count)
    for walk in walks:
        steps = np.eye(walk.stop - walk.start) - np.eye(walk.stop - walk.start, k=-1)
        precision[walk, walk] = steps.T @ steps
    return precision


def _solved(information: np.ndarray, pull: np.ndarray, which: np.ndarray, rest: np.ndarray) -> np.ndarray:
    """(N,) solution where `which` are held by a distribution of theirs, and of the `rest` not all need be told."""
    inner = cho_factor(information[np.ix_(which, which)])
    mixed = information[np.ix_(which, rest)]
    by_rest = cho_solve(inner, mixed)
    left = np.linalg.pinv(information[np.ix_(rest, rest)] - mixed.T @ by_rest, hermitian=True)
    out = np.zeros(len(pull))
    out[rest] = left @ (pull[rest] - by_rest.T @ pull[which])
    out[which] = cho_solve(inner, pull[which]) - by_rest @ out[rest]
    return out

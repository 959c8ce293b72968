"""Numbers of all bins, or patches, many and each of them small: drawn from one distribution, whose width the data tell.

Each bin's number fitted by itself follows noise as well as what is there; it predicts other frames worse the weaker the
pattern is, until it predicts nothing that is seen in the sum of them all. Taken as drawn from a normal distribution
about nothing they are shrunk towards it by as much as noise has widened them (James and Stein 1961; the width by
maximum likelihood, the numbers integrated out: Morris 1983, J. Am. Stat. Assoc. 78, 47). Edges of bins are drawn each
by itself, as where a delay line's taps are off, or their distances are, as where bins are unequally wide: then an edge
lies where the widths before it end, and the edges walk. The likelier of the two is taken. Of a likelihood that is
normal about its best, of information I and precision Λ of the distribution, all of this is linear.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag, cho_factor, cho_solve
from scipy.optimize import minimize_scalar

from mismatch.coordinate import to_coordinate
from mismatch.form import DRAWN, Form

# Numbers of these may walk; of many of those a recording may tell nothing, so that a fit holds them until it is known
# how they are drawn, by a normal distribution of so many starts.
EDGES, PATCH = ("edge", "zone edge"), "patch"
HELD = 5.0
# The width lies between these parts of what would be seen, and of what could be.
LEAST, MOST = 1e-3, 1e3


@dataclass(frozen=True, eq=False)
class Pattern:
    """What is known of numbers that are drawn.

    which: (K,) coordinates. width: of their distribution, or of that of their distances. precision: (K, K) inverse of
    its covariance. cost: deviance that the numbers must gain, Schwarz's price of single ones in other places.
    effective: how many numbers they are worth.
    """

    which: np.ndarray
    width: float
    precision: np.ndarray
    cost: float
    effective: float

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
    found = (_likeliest(shape, alone, score) for shape in _shapes(forms))
    _, square, told, shape = min(found, key=lambda one: one[0])
    precision = np.linalg.inv(shape) / square
    pull = np.zeros(len(x))
    pull[which] = precision @ away - rises
    prior = Pattern(which, float(np.sqrt(square)), precision, 0.0, 0.0).prior(len(x))
    there = x - _solved(information + prior, pull, which, rest)
    wider, left = 1 + square * told, there[which] - nothing
    price = float(np.log(wider).sum() + left @ precision @ left)
    return there, Pattern(which, float(np.sqrt(square)), precision, price, float((square * told / wider).sum()))


def _shapes(forms: tuple[Form, ...]) -> list[np.ndarray]:
    """(K, K) covariances, up to a factor, by which numbers may be drawn."""
    many = [
        (axis, f.sizes[name], f.sizes["bin"])
        for f in forms
        for name in f.own
        if (axis := f.effect.parameter(name).axis) in DRAWN
    ]
    each = block_diag(*(np.eye(count) for _, count, _ in many))
    if all(axis not in EDGES for axis, *_ in many):
        return [each]
    return [
        each,
        block_diag(*(_walks(bins, count // bins) if a in EDGES else np.eye(count) for a, count, bins in many)),
    ]


def _walks(bins: int, zones: int) -> np.ndarray:
    """Covariance of edges of some zones where widths are drawn: of edge e, e widths, and one for the first."""
    return np.kron(np.eye(zones), 1.0 + np.minimum.outer(np.arange(bins), np.arange(bins)))


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


def _seen(shape: np.ndarray, information: np.ndarray, score: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(K,) each: information of independent numbers of width 1 that make these, and the score of them at nothing."""
    root = np.linalg.cholesky(shape)
    told, ways = np.linalg.eigh(root.T @ information @ root)
    return np.maximum(told, 0.0), ways.T @ root.T @ score


def _likeliest(
    shape: np.ndarray, information: np.ndarray, score: np.ndarray
) -> tuple[float, float, np.ndarray, np.ndarray]:
    """Minus twice the logarithm of the likelihood at the likeliest width, up to a constant; its square.

    And what information there is of each independent number (K,), of which the shape makes these; the shape.
    """
    told, promised = _seen(shape, information, score)

    def loss(log_width: float) -> float:
        square = np.exp(2 * log_width)
        wider = 1 + square * told
        # At the best of all the score is told times what is found: that squared, less what a width explains of it.
        return float((np.log(wider) - square * promised**2 / wider).sum())

    seen = -0.5 * np.log(max(told.max(initial=0.0), 1e-12))
    found = minimize_scalar(loss, bounds=(seen + np.log(LEAST), seen + np.log(MOST)), method="bounded")
    return float(found.fun), float(np.exp(2 * found.x)), told, shape

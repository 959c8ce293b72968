"""Numbers of all bins, many and each of them small: drawn from one distribution, the width of which the data tell.

Each bin's number fitted by itself follows noise as well as what is there; it predicts other frames worse the weaker the
pattern is, until it predicts nothing that is seen in the sum of them all. Taken as drawn from a normal distribution
about nothing they are shrunk towards it by as much as noise has widened them (James and Stein 1961; the width by
maximum likelihood, the numbers integrated out: Morris 1983, J. Am. Stat. Assoc. 78, 47). Of a likelihood that is normal
about its best, of information I and precision Λ of the distribution, all of this is linear.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from mismatch.coordinate import to_coordinate
from mismatch.form import Form

# Of what each has a number of its own that is drawn: of these there are many.
AXES = ("bin", "edge")
# The width lies between these parts of what would be seen, and of what could be.
LEAST, MOST = 1e-3, 1e3


@dataclass(frozen=True, eq=False)
class Pattern:
    """What is known of numbers that are drawn.

    which: (K,) coordinates. precision: inverse square of the width of their distribution. cost: deviance that the
    numbers must gain, Schwarz's price of single ones in other places. effective: how many numbers they are worth.
    """

    which: np.ndarray
    precision: float
    cost: float
    effective: float

    def prior(self, count: int) -> np.ndarray:
        """(N, N) precision of N coordinates."""
        out = np.zeros(count)
        out[self.which] = self.precision
        return np.diag(out)


def drawn(forms: tuple[Form, ...]) -> np.ndarray:
    """(K,) coordinates, log gain first, that are numbers of each bin or edge."""
    each = [p for form in forms for p in form.coordinates]
    return np.array([i for i, (p, place) in enumerate(each, 1) if place is not None and p.axis in AXES], int)


def shrunk(forms: tuple[Form, ...], x: np.ndarray, information: np.ndarray) -> tuple[np.ndarray, Pattern]:
    """(N,) coordinates as likely as can be under numbers that are drawn, from the best x of all, and their pattern.

    information: (N, N) there.
    """
    which = drawn(forms)
    rest = np.setdiff1d(np.arange(len(x)), which)
    parameters = [p for form in forms for p, _ in form.coordinates]
    nothing = np.array([to_coordinate(parameters[i - 1], parameters[i - 1].vanishes_at) for i in which])
    mixed = information[np.ix_(which, rest)]
    inner = information[np.ix_(rest, rest)]
    alone = information[np.ix_(which, which)] - mixed @ np.linalg.pinv(inner, hermitian=True) @ mixed.T
    told, ways = np.linalg.eigh(alone)
    told, along = np.maximum(told, 0.0), ways.T @ (x[which] - nothing)

    def cost(log_width: float) -> float:
        wider = 1 + np.exp(2 * log_width) * told
        return float((np.log(wider) + along**2 * told / wider).sum())

    seen = -0.5 * np.log(max(told.max(initial=0.0), 1e-12))
    found = minimize_scalar(cost, bounds=(seen + np.log(LEAST), seen + np.log(MOST)), method="bounded")
    square = float(np.exp(2 * found.x))
    prior = np.zeros(len(x))
    prior[which] = 1 / square
    away = np.zeros(len(x))
    away[which] = x[which] - nothing
    there = x - np.linalg.pinv(information + np.diag(prior), hermitian=True) @ (prior * away)
    wider = 1 + square * told
    price = float(np.log(wider).sum() + ((there[which] - nothing) ** 2).sum() / square)
    return there, Pattern(which, 1 / square, price, float((square * told / wider).sum()))

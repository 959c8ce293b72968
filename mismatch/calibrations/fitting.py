"""How a set of departures carries the first calibration to the second, fitted to some positions."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from mismatch.calibrations.departure import Departure
from mismatch.calibrations.pair import Pair

STEPS = 12
# Of the peak: what is fainter weighs less, for faint parts of a map are stray light of their own timing.
FAINT = 0.05
MEDIAN_OF_NORMAL = 0.6745
# No relation is taken to be better than 2 %: where none was, the noise of faint samples would outweigh the bright.
LEAST_SCATTER, MOST_SCATTER = 0.02, 1.0


@dataclass(frozen=True, eq=False)
class Fitted:
    """departures: in the order they were found. x: (N,) common log gain, then each departure's numbers.

    scatter: relative standard deviation, beyond the noise, of what the departures leave. covariance: (N, N).
    """

    departures: tuple[Departure, ...]
    x: np.ndarray
    scatter: float
    covariance: np.ndarray

    def numbers(self, zones: int) -> list[slice]:
        """Where in `x` each departure's numbers are."""
        ends = np.cumsum([1, *(d.count(zones) for d in self.departures)])
        return [slice(int(a), int(b)) for a, b in pairwise(ends)]

    def predicted(self, pair: Pair) -> np.ndarray:
        """(P, K) counts that the second calibration should show, from the first."""
        return predicted(pair, self.departures, self.x)

    def cost(self, pair: Pair, scatter: float | None = None) -> np.ndarray:
        """(P, K) robust deviance of each sample."""
        r = self.residual(pair, self.scatter if scatter is None else scatter)
        return 2 * (np.sqrt(1 + r**2) - 1)

    def residual(self, pair: Pair, scatter: float) -> np.ndarray:
        """(P, K) standardised difference of the second calibration and its prediction."""
        return (pair.b - self.predicted(pair)) / sigma(pair, scatter)


def sigma(pair: Pair, scatter: float) -> np.ndarray:
    """(P, K) counts: noise, and the relative scatter that no departure explains."""
    size = pair.b**2 + (FAINT * pair.b.max(axis=1, keepdims=True)) ** 2
    return np.sqrt(pair.noise**2 + scatter**2 * size)


def predicted(pair: Pair, departures: tuple[Departure, ...], x: np.ndarray) -> np.ndarray:
    """(P, K) counts of the second calibration: departures act on the first, in the order of their stages."""
    light, at, plan = pair.a, 1, []
    for d in departures:
        count = d.count(len(pair.a))
        plan.append((d.stage, at, d, x[at : at + count]))
        at += count
    for _, _, d, mine in sorted(plan, key=lambda entry: entry[:2]):
        light = d.apply(pair, light, mine)
    return light * pair.unit * np.exp(np.clip(x[0], -5, 5))


def jacobian(pair: Pair, departures: tuple[Departure, ...], x: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """(P·K, M) counts per scale of each number in `columns`, by differences."""
    scales = all_scales(departures, len(pair.a))
    here = predicted(pair, departures, x)
    out = np.empty((here.size, len(columns)))
    for j, i in enumerate(columns):
        step = 1e-3 * scales[i]
        moved = x.copy()
        moved[i] += step
        out[:, j] = (predicted(pair, departures, moved) - here).ravel() / 1e-3
    return out


def all_scales(departures: tuple[Departure, ...], zones: int) -> np.ndarray:
    """(N,) scale of each number, the gain's first."""
    return np.concatenate([[1.0], *(d.scales(zones) for d in departures)])


def fit(pair: Pair, departures: tuple[Departure, ...], x: np.ndarray, scatter: float) -> Fitted:
    """Most probable numbers: pseudo-Huber loss by reweighting (Holland & Welsch 1977), steps damped (Marquardt 1963).

    Strengths have a normal prior of their scale around 0, shapes none: a zone that the data do not tell stays at 0.
    """
    zones = len(pair.a)
    scales = all_scales(departures, zones)
    numbers = [np.arange(d.count(zones)) < d.strength_count(zones) for d in departures]
    prior = np.concatenate([[0.0], *numbers]).astype(float)
    x, damping = x.astype(float).copy(), 1e-3
    width = sigma(pair, scatter)

    def target(at: np.ndarray) -> tuple[float, np.ndarray]:
        r = ((pair.b - predicted(pair, departures, at)) / width).ravel()
        return float(2 * (np.sqrt(1 + r**2) - 1).sum() + (prior * (at / scales) ** 2).sum()), r

    value, r = target(x)
    for _ in range(STEPS):
        pull = r / np.sqrt(1 + r**2)
        j = jacobian(pair, departures, x, np.arange(len(x))) / width.ravel()[:, None]
        information = (j / np.sqrt(1 + r**2)[:, None]).T @ j + np.diag(prior)
        slope = j.T @ pull - prior * x / scales
        gained = 0.0
        for _ in range(6):
            step = np.linalg.solve(information + damping * np.diag(np.diag(information) + 1e-9), slope)
            there, r_there = target(x + step * scales)
            if there < value:
                gained = value - there
                x, value, r, damping = x + step * scales, there, r_there, damping / 5
                break
            damping *= 8
        if gained < 0.05:
            break
    return Fitted(departures, x, scatter, _covariance(pair, information, j, pull) * np.outer(scales, scales))


def _covariance(pair: Pair, information: np.ndarray, j: np.ndarray, pull: np.ndarray) -> np.ndarray:
    """(N, N) from how slopes vary from tile to tile (Liang & Zeger 1986): samples of a tile are not independent."""
    tile = np.tile(np.unique(pair.tile, return_inverse=True)[1], len(pair.a))
    slopes = np.stack([np.bincount(tile, column * pull) for column in j.T], axis=1)
    slopes -= slopes.mean(axis=0)
    inverse = np.linalg.pinv(information)
    return inverse @ (slopes.T @ slopes) @ inverse


def settled(pair: Pair, departures: tuple[Departure, ...], x: np.ndarray, scatter: float) -> Fitted:
    """A fit with the scatter that it leaves."""
    fitted = fit(pair, departures, x, scatter)
    left = scatter_left(pair, fitted)
    return fit(pair, departures, fitted.x, left) if abs(left - scatter) > 0.05 * scatter else fitted


def scatter_left(pair: Pair, fitted: Fitted) -> float:
    """Relative scatter at which half of the well lit samples lie within 0.67 standard deviations."""
    lit = pair.b > FAINT * pair.b.max(axis=1, keepdims=True)
    off = np.abs(pair.b - fitted.predicted(pair))[lit]
    low, high = LEAST_SCATTER, MOST_SCATTER
    for _ in range(25):
        middle = (low + high) / 2
        if np.median(off / sigma(pair, middle)[lit]) > MEDIAN_OF_NORMAL:
            low = middle
        else:
            high = middle
    return high

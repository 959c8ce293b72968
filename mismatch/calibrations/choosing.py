"""Which departures: forward selection on one colour of the tiles, decided on the other."""

from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

from mismatch.calibrations.catalogue import catalogue
from mismatch.calibrations.departure import Departure
from mismatch.calibrations.fitting import Fitted, jacobian, settled, sigma
from mismatch.calibrations.pair import Pair

SIGNIFICANT = 1e-3
MOST = 8
BEGINNINGS = 3
START_SCATTER = 0.3
FITTED = 4  # departures that promise most are fitted in full in each round


@dataclass(frozen=True, eq=False)
class Candidate:
    """A departure beside those already chosen.

    train_gain: robust deviance gained on the tiles that choose, less the price of its numbers. gain: on those held
    out. multiple: how many times its change is in the tiles held out, 1 if it is the cause. t, p_value: of that.
    """

    departure: Departure
    fit: Fitted
    train_gain: float
    gain: float
    multiple: float
    t: float
    p_value: float


@dataclass(frozen=True, eq=False)
class Round:
    """One step. candidates: best first. tried: forms looked at, for the correction of p-values."""

    before: Fitted
    candidates: tuple[Candidate, ...]
    chosen: Candidate | None
    tried: int


def promise(pair: Pair, now: Fitted, new: Departure) -> list[tuple[float, np.ndarray]]:
    """Deviance a departure promises to first order, less its numbers' price, and where to begin its fit; best first.

    A score test: everything already fitted moves along (Rao 1948).
    """
    zones = len(pair.a)
    both, width = (*now.departures, new), sigma(pair, now.scatter).ravel()
    r = (pair.b - now.predicted(pair)).ravel() / width
    weight = (1 + r**2) ** -0.25
    old = jacobian(pair, now.departures, now.x, np.arange(len(now.x))) / width[:, None] * weight[:, None]
    q = np.linalg.qr(old)[0]
    scales, strong = new.scales(zones), new.strength_count(zones)
    found = []
    for shapes in new.tries(pair):
        x = np.concatenate([now.x, np.zeros(strong), shapes])
        own = jacobian(pair, both, x, len(now.x) + np.arange(strong)) / width[:, None] * weight[:, None]
        own = own - q @ (q.T @ own)
        slope = own.T @ (r * weight)
        step = np.linalg.solve(own.T @ own + np.eye(strong), slope)
        x[len(now.x) : len(now.x) + strong] = np.clip(step, -1, 1) * scales[:strong]
        found.append((float(step @ slope) - price(pair) * (strong + len(shapes)), x))
    return sorted(found, key=lambda one: -one[0])


def price(pair: Pair) -> float:
    """Deviance that a number must gain to be worth having (Schwarz 1978)."""
    return float(np.log(pair.b.size))


def judged(pair: Pair, before: Fitted, after: Fitted, tried: int) -> tuple[float, float, float]:
    """How many times the change that a fit makes is in these positions: multiple, its t, and p-value for `tried` forms.

    Regression of what is left on the change, with the error from tile to tile (Liang & Zeger 1986, Eq. 8): samples of
    one tile share SPADs and are not independent, tiles nearly are. Student's, with as many tiles as carry the change.
    """
    width = sigma(pair, before.scatter)
    left = before.residual(pair, before.scatter)
    weight = 1 / np.sqrt(1 + left**2)
    change = (after.predicted(pair) - before.predicted(pair)) / width
    tile = np.unique(pair.tile, return_inverse=True)[1]
    slope = np.bincount(tile, (weight * change * left).sum(axis=0))
    information = np.bincount(tile, (weight * change**2).sum(axis=0))
    whole = information.sum()
    if not whole > 0:
        return 0.0, 0.0, 1.0
    multiple = slope.sum() / whole
    error = np.sqrt(((slope - multiple * information) ** 2).sum()) / whole
    tiles = max(whole**2 / (information**2).sum(), 2.0)
    t = float(multiple / max(error, 1e-12))
    return float(multiple), t, float(min(1.0, tried * student.sf(t, tiles - 1)))


def gained(pair: Pair, before: Fitted, after: Fitted) -> float:
    """Robust deviance gained, at the same scatter for both."""
    return float((before.cost(pair, before.scatter) - after.cost(pair, before.scatter)).sum())


def select(train: Pair, held: Pair) -> list[Round]:
    """Add one departure at a time while the tiles held out agree."""
    now = settled(train, (), np.zeros(1), START_SCATTER)
    rounds: list[Round] = []
    for _ in range(MOST):
        taken = {d.id for d in now.departures}
        open_ = [d for d in catalogue() if d.id not in taken]
        promised = sorted(((promise(train, now, d), d) for d in open_), key=lambda one: -one[0][0][0])
        looked = [one for one in promised if one[0][0][0] > 0][:FITTED]
        looked = [_candidate(train, held, now, d, begins, len(open_)) for begins, d in looked]
        found = [c for c in looked if c is not None]
        found.sort(key=lambda c: -c.train_gain)
        passed = [c for c in found if c.p_value < SIGNIFICANT and c.gain > 0 and c.train_gain > 0]
        rounds.append(Round(now, tuple(found), passed[0] if passed else None, len(open_)))
        if not passed:
            return rounds
        now = passed[0].fit
    rounds.append(Round(now, (), None, 0))
    return rounds


def _candidate(train: Pair, held: Pair, now: Fitted, new: Departure, begins, tried: int) -> Candidate | None:
    """A departure fitted beside those chosen, from the most promising of its tries; None where its shapes run away."""
    tries = [settled(train, (*now.departures, new), x, now.scatter) for _, x in begins[:BEGINNINGS]]
    fits = [f for f in tries if _inside(f, train)]
    if not fits:
        return None
    fitted = max(fits, key=lambda f: gained(train, now, f))
    multiple, t, p = judged(held, now, fitted, tried)
    own = price(train) * new.count(len(train.a))
    return Candidate(new, fitted, gained(train, now, fitted) - own, gained(held, now, fitted), multiple, t, p)


def _inside(fitted: Fitted, pair: Pair) -> bool:
    """Whether every departure of a fit is what it means."""
    numbers = fitted.numbers(len(pair.a))
    return all(d.inside(fitted.x[mine]) for d, mine in zip(fitted.departures, numbers, strict=True))

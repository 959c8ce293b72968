"""Nuisances, gain that fluctuates and a clock that was estimated: what they leave of a misfit."""

import numpy as np

from mismatch.columns import Rows, by_frame, product, scaled
from mismatch.poisson import LEAST, deviance
from mismatch.settled import Settled, changed
from mismatch.simulation import Simulation

# Steps of an estimated clock to its best, and deviance by which one must still gain; part of what one gained that the
# next may at most. A step that gains nothing is halved so often.
TURNS, SETTLED, SLOWEST, HALVINGS = 20, 1e-2, 0.25, 4
# Part of an information that may be lost in rounding where the clock's is taken off.
ROUNDING = 1e-4


class Nuisances:
    """Each frame's signal times 1 + u, with u normal of mean 0 and relative standard deviation `sigma`.

    And a clock that was estimated, off by what is likeliest beside any model of the rest: `Simulation.loose` times b,
    with b normal of mean 0 and standard deviation 1. Neither has a name; both are at their best wherever models are
    compared (Pawitan 2001, In All Likelihood, section 17: penalised, as random effects are).

    It remembers where the clock was, as models that are compared one after the other differ by little; and begins where
    `remember` was told last that it is.
    """

    def __init__(self, simulation: Simulation, sigma: float) -> None:
        """Of a simulation. sigma: relative, of frames' gains."""
        self.simulation, self.sigma = simulation, sigma
        self._last: tuple[np.ndarray, Settled] | None = None
        self._begin, self._near = simulation.remembered.clock or (None, None)

    def remember(self) -> None:
        """Others of this simulation are to begin where the clock is. Not where several are made at once."""
        if self._last is not None and self._near is not None:
            self.simulation.remembered.clock = self._last[1].b, self._near

    def settled(self, expected: np.ndarray) -> Settled:
        """Expected counts (F, P, T) with an estimated clock at its best."""
        if self.simulation.loose is None:
            return Settled(expected, np.zeros(0), np.ones(1), np.ones(1))
        if self._last is None or self._last[0] is not expected:
            self._last = expected, self._settled(expected)
        return self._last[1]

    def _settled(self, expected: np.ndarray) -> Settled:
        """See `settled`: by scoring steps from where the clock was, or from where it was estimated.

        With one information, taken anew where they gain less than they should: it hardly changes.
        """
        loose = self.simulation.loose_rows

        def at(b: np.ndarray) -> tuple[float, Settled]:
            there = changed(expected, (b.astype(loose.dtype) @ loose).reshape(expected.shape), b)
            return self._cost(there), there

        before = self._begin if self._last is None else self._last[1].b
        starts = [np.zeros(len(loose)), *([] if before is None else [before])]
        lowest, now = min((at(b) for b in starts), key=lambda start: start[0])
        due = np.inf
        for _ in range(TURNS):
            gradient = self._score(now.mean, loose, now.by_clock) - now.b
            anew = self._near is None or gradient @ self._near @ gradient > due
            if anew:
                self._near = self._inverse(now)
            step = self._near @ gradient
            due = SLOWEST * gradient @ step
            if due < SLOWEST * SETTLED:
                break
            tries = (at(now.b + part * step) for part in 0.5 ** np.arange(HALVINGS))
            better = next(((cost, there) for cost, there in tries if cost < lowest), None)
            if better is None and anew:
                break
            due = 0.0 if better is None else due
            lowest, now = better or (lowest, now)
        return now

    def _cost(self, settled: Settled) -> float:
        """Deviance with the frames' own gains at their best, b² for each number of the clock and u²/σ² for each."""
        mean, b, u = settled.mean, settled.b, self.best(settled.mean)
        total = float(deviance(self.simulation.counts, self._with(mean, u)).sum() + b @ b)
        return total + (float((u**2).sum()) / self.sigma**2 if self.sigma else 0.0)

    def best(self, expected: np.ndarray) -> np.ndarray:
        """(F,) most likely u: a step of scoring, and one of Newton from there."""
        u = np.zeros(len(expected))
        if not self.sigma:
            return u
        counts, signal, prior = self.simulation.counts, self._signal(expected), 1 / self.sigma**2
        for observed in (False, True):
            mean = np.maximum(self._with(expected, u), LEAST)
            each = signal / mean
            score = (each * counts).sum(axis=(1, 2)) - signal.sum(axis=(1, 2)) - u * prior
            bend = (each**2 * counts if observed else each * signal).sum(axis=(1, 2)) + prior
            u = np.clip(u + score / bend, -0.9, 9)
        return u

    def _signal(self, expected: np.ndarray) -> np.ndarray:
        """(F, P, T) of expected counts what a laser sent."""
        return np.maximum(expected - self.simulation.dark, 0)

    def _with(self, expected: np.ndarray, u: np.ndarray) -> np.ndarray:
        """(F, P, T) expected counts with gains of the frames."""
        return expected + u[:, None, None] * self._signal(expected) if self.sigma else expected

    def applied(self, expected: np.ndarray) -> np.ndarray:
        """(F, P, T) expected counts with the clock and the frames' own gains at their best."""
        return self._with_gains(self.settled(expected).mean)

    def _with_gains(self, expected: np.ndarray) -> np.ndarray:
        """(F, P, T) expected counts with the frames' own gains at their best."""
        return self._with(expected, self.best(expected))

    def deviance(self, expected: np.ndarray) -> float:
        """Deviance with the clock and the frames' own gains at their best, b² for each number and u²/σ² for each."""
        return self._cost(self.settled(expected))

    def product(self, expected: np.ndarray, one: np.ndarray, other: np.ndarray) -> float:
        """Of two changes of expected counts (F, P, T), by the inverse covariance of all that scatters.

        That is photons, and few directions more: those of each frame's signal, and of the clock (Woodbury 1950).
        """
        now, rows = self.settled(expected), np.stack([one.ravel(), other.ravel()])
        mean, noisy, loose = now.mean, self._with_gains(now.mean), self.clock_rows(now)
        found, mixed = self._information(mean, noisy, rows)[0, 1], self._information(mean, noisy, rows, loose)
        inner = self._information(mean, noisy, loose) + np.eye(len(loose))
        return float(found - mixed[0] @ np.linalg.solve(inner, mixed[1]))

    def normal_equations(
        self, expected: np.ndarray, columns: Rows, *, nearly: bool = False
    ) -> tuple[np.ndarray, np.ndarray]:
        """(N,) score and (N, N) information of coordinates, the clock and the frames' gains projected out.

        columns: (F·P·T, N) derivatives of expected counts. nearly: with the information of the clock as it was
        elsewhere, enough for a step as the score is the same; not where that takes more than there is: uphill.
        """
        now = self.settled(expected)
        rows = columns.T if self.simulation.loose is None else scaled(columns.T, now.by_expected.ravel())
        score, information = self._score(now.mean, rows), self._information(now.mean, now.mean, rows)
        if self.simulation.loose is None:
            return score, information
        mixed = self._information(now.mean, now.mean, rows, loose := self.clock_rows(now))
        taken = mixed @ (self._near if nearly else self._inverse(now))
        left = information - taken @ mixed.T
        if nearly and not _positive(left, information):
            taken = mixed @ (near := self._inverse(now))
            self._near, left = near, information - taken @ mixed.T
        return score - taken @ (self._score(now.mean, loose) - now.b), left

    def clock_rows(self, now: Settled) -> np.ndarray:
        """(K, F·P·T) changes of counts with numbers of an estimated clock, where it is; no rows where it is known."""
        loose = self.simulation.loose_rows
        if loose is None:
            return np.zeros((0, now.mean.size))
        return loose * now.by_clock.ravel().astype(loose.dtype) if (now.by_clock != 1).any() else loose

    def _inverse(self, now: Settled) -> np.ndarray:
        """(K, K) of the information of numbers of the clock, prior included."""
        loose = self.clock_rows(now)
        return np.linalg.inv(self._information(now.mean, now.mean, loose) + np.eye(len(loose)))

    def _score(self, expected: np.ndarray, rows: Rows, slope: np.ndarray | float = 1.0) -> np.ndarray:
        """(N,) of changes (N, F·P·T) times a slope of each cell, the frames' gains at their best."""
        u = self.best(expected)
        counts, mean = self.simulation.counts, self._with(expected, u)
        left = counts / np.maximum(mean, LEAST) - 1
        # A cell that is empty as it should be is no emptier for less light (`poisson.deviance`).
        left[(mean < LEAST) & (counts == 0)] = 0.0
        # Where gains are at their best what changes them changes nothing.
        left *= np.where(expected > self.simulation.dark, 1 + u[:, None, None], 1.0)
        return rows @ (slope * left).ravel().astype(rows.dtype)

    def _information(
        self, expected: np.ndarray, mean: np.ndarray, rows: Rows, others: Rows | None = None
    ) -> np.ndarray:
        """(N, M) of changes (N, F·P·T) and (M, F·P·T), by photons that scatter about `mean`, and the frames' gains."""
        mean = np.maximum(mean, LEAST)
        if others is None:
            white = scaled(rows, (1 / np.sqrt(mean)).ravel().astype(rows.dtype))
            information, others = product(white, white), rows
        else:
            weighted = scaled(rows, (1 / mean).ravel().astype(rows.dtype)).astype(others.dtype, copy=False)
            information = product(weighted, others)
        if self.sigma:
            signal = self._signal(expected)
            each = (signal**2 / mean).sum(axis=(1, 2)) + 1 / self.sigma**2
            mixed = by_frame(rows, signal / mean)
            theirs = mixed if others is rows else by_frame(others, signal / mean)
            information = information - (mixed / each) @ theirs.T
        return information


def _positive(left: np.ndarray, whole: np.ndarray) -> bool:
    """Whether a matrix (N, N) bends down nowhere, but for the rounding of what it is left of."""
    try:
        np.linalg.cholesky(left + ROUNDING * np.diag(np.diag(whole)))
    except np.linalg.LinAlgError:
        return False
    return True

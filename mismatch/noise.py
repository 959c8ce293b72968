"""Nuisances, gain that fluctuates and a clock that was estimated: what they leave of a misfit."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from mismatch.poisson import LEAST, deviance
from mismatch.simulation import Simulation

MOST_SIGMA = 1.0
# Steps of an estimated clock to its best, and deviance by which one must still gain; part of what one gained that the
# next may at most. What is expected falls to no less than this part by it.
TURNS, SETTLED, SLOWEST, LOWEST = 8, 1e-3, 0.25, 0.1
# Twice the log-likelihood by which fluctuation must be better than none: one in twenty by chance, as it is no name but
# what others are judged beside.
SHOWN = 2.7
# Twice the log-likelihood that speaks against it for good: one in a hundred by chance. Third differences of noise are
# correlated, by the squares of which (0.75, 0.3, 0.05, on either side) so many tell as much as one that is not.
REFUTED, ALIKE = 6.6, 2.31


@dataclass(frozen=True, eq=False)
class Nuisances:
    """Each frame's signal times 1 + u, with u normal of mean 0 and relative standard deviation `sigma`.

    And a clock that was estimated, off by what is likeliest beside any model of the rest: `Simulation.loose` times b,
    with b normal of mean 0 and standard deviation 1. Neither has a name; both are at their best wherever models are
    compared (Pawitan 2001, In All Likelihood, section 17: penalised, as random effects are).
    """

    simulation: Simulation
    sigma: float

    def settled(self, expected: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(F, P, T) expected counts with an estimated clock at its best, and (K,) b.

        By scoring steps with one information, taken anew where they gain less than they should: it hardly changes.
        """
        loose, inverses = self.simulation.loose_rows, self.simulation.inverses
        if loose is None:
            return expected, np.zeros(0)
        mean, b, due = expected, np.zeros(len(loose)), np.inf
        for _ in range(TURNS):
            gradient = self._score(mean, loose) - b
            if self.sigma not in inverses or gradient @ inverses[self.sigma] @ gradient > due:
                inverses[self.sigma] = np.linalg.inv(self._information(mean, mean, loose) + np.eye(len(b)))
            step = inverses[self.sigma] @ gradient
            due = SLOWEST * gradient @ step
            if due < SLOWEST * SETTLED:
                break
            b = b + step
            change = (b.astype(loose.dtype) @ loose).reshape(expected.shape)
            mean = np.maximum(expected + change, LOWEST * expected)
        return mean, b

    def _pieces(self, expected: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Signal (F, P, T), and by frame (F,) the score of u and its information, prior included."""
        mean = np.maximum(expected, LEAST)
        signal = np.maximum(expected - self.simulation.dark, 0)
        score = (signal * (self.simulation.counts / mean - 1)).sum(axis=(1, 2))
        return signal, score, (signal**2 / mean).sum(axis=(1, 2)) + 1 / self.sigma**2

    def best(self, expected: np.ndarray) -> np.ndarray:
        """(F,) most likely u."""
        if not self.sigma:
            return np.zeros(len(expected))
        _, score, information = self._pieces(expected)
        return np.clip(score / information, -0.9, 9)

    def applied(self, expected: np.ndarray) -> np.ndarray:
        """(F, P, T) expected counts with the clock and the frames' own gains at their best."""
        return self._with_gains(self.settled(expected)[0])

    def _with_gains(self, expected: np.ndarray) -> np.ndarray:
        """(F, P, T) expected counts with the frames' own gains at their best."""
        if not self.sigma:
            return expected
        return expected + self.best(expected)[:, None, None] * np.maximum(expected - self.simulation.dark, 0)

    def deviance(self, expected: np.ndarray) -> float:
        """Deviance with the clock and the frames' own gains at their best, b² for each number and u²/σ² for each."""
        expected, b = self.settled(expected)
        total = float(deviance(self.simulation.counts, self._with_gains(expected)).sum() + b @ b)
        return total + (float((self.best(expected) ** 2).sum()) / self.sigma**2 if self.sigma else 0.0)

    def product(self, expected: np.ndarray, one: np.ndarray, other: np.ndarray) -> float:
        """Of two changes of expected counts (F, P, T), by the inverse covariance of all that scatters.

        That is photons, and few directions more: those of each frame's signal, and of the clock (Woodbury 1950).
        """
        expected, rows = self.settled(expected)[0], np.stack([one.ravel(), other.ravel()])
        information = self._information(expected, self._with_gains(expected), self._with_loose(rows))
        found, mixed, inner = information[0, 1], information[:2, 2:], information[2:, 2:]
        return float(found - mixed[0] @ np.linalg.solve(inner + np.eye(len(inner)), mixed[1]))

    def normal_equations(self, expected: np.ndarray, columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(N,) score and (N, N) information of coordinates, the clock and the frames' gains projected out.

        columns: (F·P·T, N) derivatives of expected counts.
        """
        many, (expected, b) = columns.shape[1], self.settled(expected)
        rows = self._with_loose(columns.T)
        score, information = self._score(expected, rows), self._information(expected, expected, rows)
        mixed = information[:many, many:]
        taken = mixed @ np.linalg.inv(information[many:, many:] + np.eye(len(b)))
        return score[:many] - taken @ (score[many:] - b), information[:many, :many] - taken @ mixed.T

    def _with_loose(self, rows: np.ndarray) -> np.ndarray:
        """(N + K, F·P·T) changes, and those by the clock."""
        loose = self.simulation.loose_rows
        return rows if loose is None else np.concatenate([rows, loose])

    def _score(self, expected: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """(N,) of changes (N, F·P·T), the frames' gains projected out."""
        mean = np.maximum(expected, LEAST)
        score = rows @ (self.simulation.counts / mean - 1).ravel().astype(rows.dtype)
        if not self.sigma:
            return score
        signal, own, information = self._pieces(expected)
        return score - _by_frame(signal / mean, rows) @ (own / information)

    def _information(self, expected: np.ndarray, mean: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """(N, N) of changes (N, F·P·T), by photons that scatter about `mean`, and the frames' gains."""
        mean = np.maximum(mean, LEAST)
        information = (rows * (1 / mean).ravel().astype(rows.dtype)) @ rows.T
        if self.sigma:
            signal = np.maximum(expected - self.simulation.dark, 0)
            each = (signal**2 / mean).sum(axis=(1, 2)) + 1 / self.sigma**2
            mixed = _by_frame(signal / mean, rows)
            information = information - (mixed / each) @ mixed.T
        return information


def _by_frame(weighted: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """(N, F) products of changes with weighted signal (F, P, T), frame by frame."""
    flat = weighted.reshape(len(weighted), -1)
    return np.einsum("fc,nfc->nf", flat, rows.reshape(-1, *flat.shape))


def frame_gain_sigma(simulation: Simulation, expected: np.ndarray, *, slow: bool = False) -> float:
    """Relative standard deviation of the frames' gains, 0 where the data show none.

    Maximum likelihood from differences of successive frames: what changes slowly is a cause of its own, not noise.
    slow: from the frames themselves, if differences do not speak against it; for where no cause was found. They tell
    less, and of noise that shows they miss what by chance is slow.
    """
    if len(expected) < 4:
        return 0.0
    mean = np.maximum(expected, LEAST)
    signal = np.maximum(expected - simulation.dark, 0)
    information = (signal**2 / mean).sum(axis=(1, 2))
    if not (information > 0).all():
        return 0.0
    u = (signal * (simulation.counts / mean - 1)).sum(axis=(1, 2)) / information
    # Third differences are blind to parabolas.
    weights = np.array([1, -3, 3, -1]) / np.sqrt(20)
    told = np.convolve(u, weights, "valid"), np.convolve(1 / information, weights**2, "valid")
    sigma = _shown(*told)
    if not slow:
        return sigma
    every = _shown(u - np.average(u, weights=information), 1 / information)
    against = (_loss(every, *told) - _loss(sigma, *told)) / ALIKE
    return sigma if against > REFUTED else max(sigma, every)


def _loss(sigma: float, deviates: np.ndarray, poisson: np.ndarray) -> float:
    """Minus twice the log-likelihood of normal deviates of variance sigma² beyond Poisson's."""
    variance = sigma**2 + poisson
    return float((np.log(variance) + deviates**2 / variance).sum())


def _shown(deviates: np.ndarray, poisson: np.ndarray) -> float:
    """The likeliest sigma, 0 where that is hardly better than none."""
    found = minimize_scalar(
        lambda log_sigma: _loss(np.exp(log_sigma), deviates, poisson),
        bounds=(np.log(1e-6), np.log(MOST_SIGMA)),
        method="bounded",
    )
    return float(np.exp(found.x)) if _loss(0.0, deviates, poisson) - found.fun > SHOWN else 0.0

"""Gain that fluctuates from frame to frame: how much the data show, and what it leaves of a misfit."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from mismatch.poisson import LEAST, deviance
from mismatch.simulation import Simulation

MOST_SIGMA = 1.0
# Twice the log-likelihood by which fluctuation must be better than none: one in twenty by chance, as it is no name but
# what others are judged beside.
SHOWN = 2.7
# Twice the log-likelihood that speaks against it for good: one in a hundred by chance. Third differences of noise are
# correlated, by the squares of which (0.75, 0.3, 0.05, on either side) so many tell as much as one that is not.
REFUTED, ALIKE = 6.6, 2.31


@dataclass(frozen=True, eq=False)
class FrameGains:
    """Each frame's signal times 1 + u, with u normal of mean 0 and relative standard deviation `sigma`."""

    simulation: Simulation
    sigma: float

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
        """(F, P, T) expected counts with the frames' own gains at their best."""
        if not self.sigma:
            return expected
        return expected + self.best(expected)[:, None, None] * np.maximum(expected - self.simulation.dark, 0)

    def deviance(self, expected: np.ndarray) -> float:
        """Deviance with the frames' own gains, and u²/σ² for each."""
        total = float(deviance(self.simulation.counts, self.applied(expected)).sum())
        return total + (float((self.best(expected) ** 2).sum()) / self.sigma**2 if self.sigma else 0.0)

    def product(self, expected: np.ndarray, one: np.ndarray, other: np.ndarray) -> float:
        """Of two changes of expected counts (F, P, T), by the inverse covariance of photons and frames' gains.

        That of each frame is diagonal but for one direction, that of its signal (Sherman and Morrison 1950, Ann. Math.
        Stat. 21, 124).
        """
        weighted = one / np.maximum(self.applied(expected), LEAST)
        found = float((weighted * other).sum())
        if not self.sigma:
            return found
        mean = np.maximum(self.applied(expected), LEAST)
        signal = np.maximum(expected - self.simulation.dark, 0)
        information = (signal**2 / mean).sum(axis=(1, 2)) + 1 / self.sigma**2
        parts = [(signal * change / mean).sum(axis=(1, 2)) for change in (one, other)]
        return found - float((parts[0] * parts[1] / information).sum())

    def normal_equations(self, expected: np.ndarray, columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(N,) score and (N, N) information of coordinates, the frames' gains projected out.

        columns: (F·P·T, N) derivatives of expected counts.
        """
        mean = np.maximum(expected, LEAST)
        weighted = columns / mean.reshape(-1, 1)
        score = weighted.T @ (self.simulation.counts - mean).ravel()
        information = columns.T @ weighted
        if self.sigma:
            signal, own, own_information = self._pieces(expected)
            mixed = np.einsum(
                "fc,nfc->nf", signal.reshape(len(signal), -1), weighted.T.reshape(-1, *mean.shape[:1], signal[0].size)
            )
            score = score - mixed @ (own / own_information)
            information = information - (mixed / own_information) @ mixed.T
        return score, information


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

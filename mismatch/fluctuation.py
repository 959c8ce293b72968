"""How much gain fluctuates from frame to frame, from the frames themselves."""

import numpy as np
from scipy.optimize import minimize_scalar

from mismatch.poisson import LEAST
from mismatch.simulation import Simulation

MOST_SIGMA = 1.0
# Twice the log-likelihood by which fluctuation must be better than none: one in twenty by chance, as it is no name but
# what others are judged beside.
SHOWN = 2.7
# Twice the log-likelihood that speaks against it for good: one in a hundred by chance. Third differences of noise are
# correlated, by the squares of which (0.75, 0.3, 0.05, on either side) so many tell as much as one that is not.
REFUTED, ALIKE = 6.6, 2.31


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

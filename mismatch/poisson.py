"""Poisson noise: deviance of counts, signed residuals, and what deviance noise alone gives."""

from functools import cache

import numpy as np
from scipy.special import gammaln, xlogy

# Below this many expected counts a cell is as good as empty; what is found there all the same costs no infinite sum.
LEAST = 1e-3
# From here on the series for many counts is good to 1e-3.
MANY = 40.0
KNOTS = 400


def deviance(counts: np.ndarray, expected: np.ndarray) -> np.ndarray:
    """2·(n ln(n/μ) - n + μ) of each cell, any shape (McCullagh and Nelder 1989, section 2.3)."""
    mean = np.maximum(expected, LEAST)
    return 2 * (xlogy(counts, counts / mean) - counts + mean)


def signed(counts: np.ndarray, expected: np.ndarray) -> np.ndarray:
    """Signed square root of the deviance: about a standard normal number where many counts are expected."""
    return np.sign(counts - expected) * np.sqrt(np.maximum(deviance(counts, expected), 0))


def expected_deviance(expected: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean and variance of the deviance of Poisson counts around `expected`, cell by cell.

    Summed over all counts where few are expected, 1 + 1/(6μ) and 2 + 2/μ·(1/3) beyond (their expansions in 1/μ). Below
    `LEAST`, where deviance is that about `LEAST`, in proportion to how often one count comes.
    """
    mean = np.maximum(expected, LEAST)
    knots, means, variances = _table()
    at, dark = np.log(np.minimum(mean, MANY)), np.clip(expected / LEAST, 0, 1)
    few = 2 * LEAST + dark * (np.interp(at, knots, means) - 2 * LEAST)
    return (
        np.where(mean < MANY, few, 1 + 1 / (6 * mean)),
        np.where(mean < MANY, dark * np.interp(at, knots, variances), 2 + 2 / (3 * mean)),
    )


@cache
def _table() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Logarithms of expected counts, and mean and variance of the deviance there."""
    means = np.geomspace(LEAST, MANY, KNOTS)
    counts = np.arange(int(MANY + 12 * np.sqrt(MANY)) + 20)
    chance = np.exp(xlogy(counts, means[:, None]) - means[:, None] - gammaln(counts + 1))
    each = deviance(counts, means[:, None])
    first = (chance * each).sum(axis=1)
    return np.log(means), first, (chance * each**2).sum(axis=1) - first**2

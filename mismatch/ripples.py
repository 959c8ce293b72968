"""Rhythms over the bins that begin anew in each frame, or in each histogram: no division of the cells adds them up."""

import numpy as np
from scipy.fft import fft
from scipy.stats import gamma

from mismatch.checks import Check

# Counts that a histogram, or a frame, must expect to be asked.
ENOUGH = 20.0


def ripples(excess: np.ndarray, mean: np.ndarray) -> list[Check]:
    """The strongest rhythm of frames, and of single histograms. excess, mean: (F, P, T) counts beyond, and expected."""
    bins, found = mean.shape[2], []
    for what, one, expected in (
        ("frame to frame", excess.sum(axis=1), mean.sum(axis=1)),
        ("histogram to histogram", excess.reshape(-1, bins), mean.reshape(-1, bins)),
    ):
        p, period = strongest(one, expected)
        sentence = f"a ripple of {period:.3g} bins runs through the counts, in another phase from {what}"
        found.append(Check(p, sentence))
    return found


def strongest(excess: np.ndarray, mean: np.ndarray) -> tuple[float, float]:
    """Chance of the strongest rhythm of N histograms (N, T) whatever their phases, and its period in bins.

    The power |Σ x exp(-iωt)|² of Poisson counts with means μ, less these, is M(0) on the mean, with
    M(ω) = Σ μ exp(-iωt), and scatters by M(0)² + |M(2ω)|² + M(0): two products of second moments of a complex number
    and its fourth cumulant. Powers over M(0), added up, go as the gamma law of their mean and variance.
    """
    bins, total = mean.shape[1], mean.sum(axis=1)
    told = total > ENOUGH
    if not told.any() or bins < 4:
        return 1.0, float(bins)
    total, waves = total[told], np.arange(1, bins + 1)
    power = (np.abs(fft(excess[told], 2 * bins)[:, waves]) ** 2 / total[:, None]).sum(axis=0)
    double = np.abs(fft(mean[told], 2 * bins)[:, 2 * waves % (2 * bins)]) / total[:, None]
    variance = (1 + double**2 + 1 / total[:, None]).sum(axis=0)
    chance = gamma.sf(power, len(total) ** 2 / variance, scale=variance / len(total))
    best = int(np.argmin(chance))
    return float(min(1.0, bins * chance[best])), 2 * bins / waves[best]

"""A bit of a counter that sticks: every count of a zone has it, or none that is large enough has."""

import numpy as np
from scipy.stats import poisson

from mismatch.checks import Check
from mismatch.simulation import Simulation

# Poisson counts lie within so many standard deviations of their mean, and a few.
REACH, BESIDE = 8.0, 4.0
# Counts whose mean is this many times the square of a bit's value have it as often as not, to 1e-3.
EVEN = 4.0


def stuck(simulation: Simulation, expected: np.ndarray) -> Check:
    """Whether a bit is the same in all counts of a zone, (F, P, T) of which as many are expected, by a tiny chance.

    A counter that is full lacks the bits of what it cannot hold, and has those of its largest count however many came:
    only bits below the highest that a zone has are told, by counts that are not its largest.
    """
    counts = np.rint(simulation.recorded).astype(np.int64)
    mean = expected if simulation.trust is None else expected / simulation.trust
    worst, sentence, tried = 0.0, "", 1
    for zone in range(counts.shape[1]):
        seen, due = counts[:, zone].ravel(), mean[:, zone].ravel()
        tried += int(seen.max(initial=0)).bit_length()
        free = seen < seen.max(initial=0)
        for bit in range(int(seen.max(initial=0)).bit_length() - 1):
            has = (seen[free] >> bit) & 1
            if has.all() or not has.any():
                there = set_chance(due[free], 1 << bit)
                log_p = float(np.log(np.maximum(there if has.all() else 1 - there, 1e-300)).sum())
                if log_p < worst:
                    state = "set" if has.all() else "clear"
                    worst, sentence = log_p, f"every count of zone {zone} has the bit worth {1 << bit} {state}"
    return Check(float(min(1.0, np.exp(worst) * tried)), sentence, foreign=True, certain=True)


def set_chance(mean: np.ndarray, value: int) -> np.ndarray:
    """(N,) chance that Poisson counts of these means have the bit of this value: sums over intervals of counts."""
    mean = np.asarray(mean, float)
    found = np.full(mean.shape, 0.5)
    few = mean < EVEN * value**2
    some = mean[few]
    reach = REACH * np.sqrt(some) + BESIDE
    first = np.floor(np.maximum(some - reach, 0) / (2 * value))
    most = int(np.max(2 * reach / (2 * value), initial=0)) + 2
    total = np.zeros(some.shape)
    for k in range(most):
        begin = 2 * value * (first + k) + value
        total += poisson.cdf(begin + value - 1, some) - poisson.cdf(begin - 1, some)
    found[few] = np.clip(total, 0, 1)
    return found

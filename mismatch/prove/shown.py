"""How much a concealed cause shows, and how strong it must be to show so much."""

from collections.abc import Callable

import numpy as np

from mismatch.poisson import LEAST, deviance

# Total deviance that a cause moves: log-uniform between these.
MOVED = (200.0, 5000.0)
GAIN_STEPS = 12


def moved(expected: np.ndarray, nominal: np.ndarray, dark: np.ndarray) -> float:
    """Deviance between expected counts and the nominal ones (F, P, T) at their best gain, which is fitted always.

    dark: counts that come without laser. The likelihood is concave in the gain, and its maximum at 0 or above.
    """
    signal, ratio = nominal - dark, 1.0
    for _ in range(GAIN_STEPS):
        part = signal / np.maximum(ratio * signal + dark, LEAST)
        slope, curvature = (part * expected).sum() - signal.sum(), (part**2 * expected).sum()
        ratio = max(ratio + slope / max(curvature, LEAST), 0.0)
    return float(deviance(expected, np.maximum(ratio * signal + dark, LEAST)).sum())


def strength_for(shown: Callable[[float], float], target: float) -> float | None:
    """The strength that moves the deviance by about the target, None where none does."""
    strength, best = 1.0, None
    for _ in range(25):
        now = shown(strength)
        if 0.8 * target < now < 1.25 * target:
            return strength
        if now >= MOVED[0]:
            best = strength
        factor = np.clip(np.sqrt(target / max(now, 1e-6)), 0.2, 5.0)
        strength *= factor
        if strength > 1e4:
            break
    return best

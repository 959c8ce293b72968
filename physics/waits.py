"""How long photons wait: a family of delays that holds the exponential, a plateau, a ramp and power laws."""

import numpy as np
from scipy.signal import fftconvolve, lfilter

# Heavier or lighter tails than this are followed; nearer to 0 they are exponential to the last digit that matters.
EXPONENTIAL = 1e-6
# Exponential delays are followed to so many time constants: 2e-9 is left out. Power laws to so many seconds at least.
TIME_CONSTANTS, LONGEST_S = 20.0, 2e-8


def waiting(time_s: np.ndarray, tau_s: float, heavy: float) -> np.ndarray:
    """Probability (...) of still waiting at times (...) of 0 and more: (1 + h·t/τ)^(-1/h), exp(-t/τ) at h = 0.

    The generalised Pareto distribution (Pickands 1975, Annals of Statistics 3, 119). Even up to τ at h = -1, falling
    to nothing on a straight line until 2τ at -1/2, with a density like t^(-1 - 1/h) at late times above 0.
    """
    t = np.asarray(time_s, float) / tau_s
    if abs(heavy) < EXPONENTIAL:
        return np.exp(-t)
    return np.maximum(1 + heavy * t, 0) ** (-1 / heavy)


def half_life(tau_s: float, heavy: float) -> float:
    """Seconds that half of the photons wait at least."""
    return tau_s * (np.log(2) if abs(heavy) < EXPONENTIAL else (2**heavy - 1) / heavy)


def steps_late(steps: int, step_s: float, tau_s: float, heavy: float) -> np.ndarray:
    """(steps,) share of light, even over a step, that waits into that step and each that follows.

    Exact: second differences of twice the integral of the density. What waits longer is left out.
    """
    at = step_s * np.arange(-1.0, steps + 1)
    late = np.maximum(at, 0)
    held = waiting(late, tau_s, heavy)
    if abs(heavy) < EXPONENTIAL:
        waited = tau_s * (1 - held)
    elif abs(heavy - 1) < EXPONENTIAL:
        waited = tau_s * np.log1p(late / tau_s)
    else:
        waited = tau_s / (1 - heavy) * (1 - held ** (1 - heavy))
    return np.diff(late - waited, 2) / step_s


def reach(tau_s: float, heavy: float) -> float:
    """Seconds to which delays are followed."""
    if heavy < -EXPONENTIAL:
        return min(-1 / heavy, TIME_CONSTANTS) * tau_s
    return TIME_CONSTANTS * tau_s if heavy < EXPONENTIAL else max(TIME_CONSTANTS * tau_s, LONGEST_S)


def late(light: np.ndarray, step_s: float, tau_s: float, heavy: float) -> np.ndarray:
    """(..., N) light that is even over each of N steps, delayed within reach; later than the last step it is lost."""
    if abs(heavy) < EXPONENTIAL:
        return lfilter(*_exponential(step_s, tau_s), light)
    longest = reach(tau_s, heavy)
    steps = min(int(np.ceil(longest / step_s)) + 1, light.shape[-1])
    kernel = steps_late(steps, step_s, tau_s, heavy) / (1 - float(waiting(longest, tau_s, heavy)))
    kernel = kernel.reshape((1,) * (light.ndim - 1) + (-1,))
    return np.maximum(fftconvolve(light, kernel, axes=-1)[..., : light.shape[-1]], 0)


def _exponential(step_s: float, tau_s: float) -> tuple[list[float], list[float]]:
    """Numerator and denominator of the filter that delays light exponentially, step by step.

    Of photons delayed from a step, `same` are registered within it; of those that still wait, `kept` wait on.
    """
    kept = np.exp(-step_s / tau_s)
    same = 1 + np.expm1(-step_s / tau_s) * tau_s / step_s
    return [same, (1 - kept) * (1 - same) - same * kept], [1.0, -kept]

"""Echoes: residuals that look like the signal some bins before or after, in some frames, or of another zone."""

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.stats import chi2

from mismatch.checks import Check
from mismatch.simulation import Simulation

# Bins by which the signal is displaced; a displacement of 0 is a gain.
LAGS = (-10, -7, -5, -3, -2, -1, 1, 2, 3, 4, 5, 7, 9, 12, 16, 20)
# Displacements from zone to zone that stand out most by the normal law, of which the least likely is sought.
LIKELY = 12
# One event may weigh so many times a cumulant function's scale: exp of more is no number.
STEEPEST = 60.0
TINY = 1e-12


def echoes(simulation: Simulation, expected: np.ndarray, mean: np.ndarray) -> list[Check]:
    """By frame, by zone, and from zone to zone. expected, mean: (F, P, T) without and with the frames' own gains."""
    signal = np.maximum(expected - simulation.dark, 0)
    score = simulation.counts / mean - 1
    weight = 1 / mean
    frames, zones, bins = signal.shape
    lags = [lag for lag in LAGS if abs(lag) < bins]
    by_frame, by_pair = np.zeros((2, len(lags), frames)), np.zeros((len(lags), zones, zones))
    for i, lag in enumerate(lags):
        moved = _moved(signal, lag)
        information = (weight * moved**2).sum(axis=(1, 2))
        by_frame[0, i] = _z((score * moved).sum(axis=(1, 2)), information)
        # Fourth cumulant: that of n/μ − 1 is 1/μ³. Where few counts are expected the normal law's tail is too thin.
        by_frame[1, i] = (weight**3 * moved**4).sum(axis=(1, 2)) / np.maximum(information, TINY) ** 2
        # (P, P): residuals of the first zone, signal of the second.
        apart = [a.transpose(1, 0, 2).reshape(zones, -1) for a in (score, moved, weight, moved**2)]
        by_pair[i] = _z(apart[0] @ apart[1].T, apart[2] @ apart[3].T)
    # χ² of the same mean and variance as the sum of squares has (Satterthwaite 1946).
    wider = 1 + by_frame[1].sum(axis=1) / (2 * frames)
    chances = chi2.sf((by_frame[0] ** 2).sum(axis=1) / wider, frames / wider)
    in_frames = int(np.argmin(chances))
    p_frames = min(1.0, len(lags) * float(chances[in_frames]))
    found = []
    for at in np.argsort(-np.abs(by_pair), axis=None)[:LIKELY]:
        lag, one, other = (int(n) for n in np.unravel_index(int(at), by_pair.shape))
        moved = _moved(signal[:, other], lags[lag]) / mean[:, one]
        found.append((chance(simulation.counts[:, one], mean[:, one], moved), lag, one, other))
    p_pair, lag, one, other = min(found)
    p_pair = min(1.0, 2 * by_pair.size * p_pair)
    side = "after" if lags[in_frames] > 0 else "before"
    return [
        Check(p_frames, f"an echo {abs(lags[in_frames])} bins {side} the signal differs from frame to frame"),
        Check(p_pair, f"zone {one} shows the signal of zone {other} displaced by {lags[lag]} bins"),
    ]


def _moved(signal: np.ndarray, lag: int) -> np.ndarray:
    """(..., T) signal so many bins later."""
    moved = np.zeros_like(signal)
    to, source = (slice(lag, None), slice(None, -lag)) if lag > 0 else (slice(None, lag), slice(-lag, None))
    moved[..., to] = signal[..., source]
    return moved


def chance(counts: np.ndarray, mean: np.ndarray, weights: np.ndarray) -> float:
    """How likely it is, at most, that Poisson counts have a weighted sum so far off its mean, on that side.

    Chernoff's bound (1952). The normal law would have it impossible where one event weighs much, in a cell that hardly
    expects any.
    """
    off = float((weights * (counts - mean)).sum())
    largest = float(np.abs(weights).max(initial=0))
    if off == 0 or largest <= TINY:
        return 1.0
    scaled, off = np.sign(off) * weights / largest, abs(off) / largest

    def log_bound(t: float) -> float:
        return float((mean * (np.expm1(t * scaled) - t * scaled)).sum()) - t * off

    return float(np.exp(min(0.0, minimize_scalar(log_bound, bounds=(0, STEEPEST), method="bounded").fun)))


def _z(score: np.ndarray, information: np.ndarray) -> np.ndarray:
    """Scores over their standard deviation, 0 where there is no information."""
    return np.where(information > TINY, score / np.sqrt(np.maximum(information, TINY)), 0)

"""What lags explain of an excess, to first order: of all frames alike, as time goes by, of zones in two groups."""

import numpy as np


def evenly(told: np.ndarray, found: np.ndarray, time_s: np.ndarray) -> list[dict[str, float]]:
    """Lags of frames (F,), told as well and found as large, that are the same, go with time, or both."""
    time_s = np.asarray(time_s, float)
    moments = np.array([[(told * time_s ** (i + j)).sum() for j in range(2)] for i in range(2)])
    both = np.linalg.lstsq(moments, np.array([found.sum(), (found * time_s).sum()]), rcond=None)[0]
    lag, skew = ratio(found.sum(), told.sum()), ratio((found * time_s).sum(), moments[1, 1])
    return [{"lag": lag}, {"skew": skew}, {"lag": float(both[0]), "skew": float(both[1])}]


def ratio(of: float, by: float) -> float:
    """0 where there is nothing to go by."""
    return float(of / max(by, 1e-12))


def two_groups(values: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """(P,) which of the values belong to the group farther from 0, of the two that differ most."""
    order = np.argsort(values)
    weight, sums = np.cumsum(weights[order])[:-1], np.cumsum((weights * values)[order])[:-1]
    rest, other = weights.sum() - weight, (weights * values).sum() - sums
    parts = np.where(
        (weight > 0) & (rest > 0), sums**2 / np.maximum(weight, 1e-12) + other**2 / np.maximum(rest, 1e-12), 0
    )
    at = int(parts.argmax())
    upper = np.zeros(len(values), bool)
    upper[order[at + 1 :]] = True
    farther = abs(other[at]) / max(rest[at], 1e-12) >= abs(sums[at]) / max(weight[at], 1e-12)
    return upper if farther else ~upper


def promised(told: np.ndarray, found: np.ndarray, time_s: np.ndarray) -> float:
    """Deviance that lags gain which are each zone's own, or go with time, beyond noise. told, found: (F, P)."""
    by_zone = (found.sum(axis=0) ** 2 / np.maximum(told.sum(axis=0), 1e-12)).sum() - found.shape[1]
    ahead = np.asarray(time_s, float)
    with_time = ratio((found.sum(axis=1) * ahead).sum() ** 2, (told.sum(axis=1) * ahead**2).sum()) - 1
    return max(float(by_zone), with_time)

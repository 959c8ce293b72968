"""When a timing channel that has registered an event is alive again."""

import numpy as np


def alive(met: np.ndarray, dead_bins: float) -> np.ndarray:
    """(F, P, T) chance that a channel, which meets so many photons by shot and bin, is alive in a bin."""
    bins = met.shape[-1]
    if dead_bins >= bins:
        return np.exp(met - np.cumsum(met, axis=-1))
    short = dead_bins - np.arange(bins - 1, 0, -1)  # By how much the dead time is longer than so many bins.
    still = np.where(short < 0, np.clip(1 + short, 0, 1) ** 2 / 2, 1 - np.clip(1 - short, 0, 1) ** 2 / 2)
    any_met, events, ready = -np.expm1(-met), np.zeros(met.shape), np.ones(met.shape)
    for t in range(1, bins):
        events[..., t - 1] = any_met[..., t - 1] * ready[..., t - 1]
        ready[..., t] = np.maximum(1 - events[..., :t] @ still[bins - 1 - t :], 0)
    return ready

"""How much light spreads on the way to a surface behind, or before, the one that is seen."""

import numpy as np

# A sheet in front nearer to the sensor than this, or than half the range of what is behind it, fades as it comes
# nearer: it would soon be all that is seen. Range, metres.
NEAREST_M = 0.1


def spread_by(range_m: np.ndarray, spacing_m: np.ndarray | float, falloff: float) -> np.ndarray:
    """How many times as much light returns from a surface so much farther, or nearer where all are negative."""
    there = range_m + spacing_m
    if np.max(spacing_m) >= 0:
        return (range_m / there) ** falloff
    nearest = np.minimum(NEAREST_M, range_m / 2)
    return (range_m / np.maximum(there, nearest)) ** falloff * np.clip(there / nearest, 0, 1)

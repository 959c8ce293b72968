"""Least squares within bounds, coordinate by coordinate, compiled."""

import numpy as np
from numba import njit

# Rounds through all coordinates, and by how little the last may still move any.
ROUNDS, STILL = 50, 1e-6


@njit(nogil=True, cache=True)
def bounded_least_squares(
    information: np.ndarray, promised: np.ndarray, low: np.ndarray, high: np.ndarray, start: np.ndarray
) -> np.ndarray:
    """(M,) at the maximum of 2·a·b - a·A·a within bounds; each coordinate in turn is best beside the others.

    information: (M, M) A. promised: (M,) b. low, high: (M,) bounds. start: (M,) within them.
    """
    a = start.copy()
    for _ in range(ROUNDS):
        moved = 0.0
        for i in range(len(a)):
            if information[i, i] > 0:
                there = 0.0
                for j in range(len(a)):
                    there += information[i, j] * a[j]
                best = min(max(a[i] + (promised[i] - there) / information[i, i], low[i]), high[i])
                moved = max(moved, abs(best - a[i]))
                a[i] = best
        if moved < STILL:
            break
    return a

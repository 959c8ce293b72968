"""The stretch of bins, or ranges, that explains most of an excess."""

import numpy as np


def best_interval(
    promised: np.ndarray, information: np.ndarray, by_gain: np.ndarray, whole: float
) -> tuple[int, int, float]:
    """First entry, the one after the last, and evidence of the best interval of T entries.

    promised: (T,) sums of whitened excess times a change that each entry makes. information: (T,) of those changes
    squared. by_gain: (T,) times the change that the gain makes, of which `whole` is the square. The evidence is the
    square of how many standard deviations more there is, beside a free gain; 0 where nowhere is more.
    """
    heaps = [np.concatenate([[0.0], np.cumsum(values)]) for values in (promised, information, by_gain)]
    # Row: where it begins; column: where it ends.
    more, square, mixed = (heap[None] - heap[:, None] for heap in heaps)
    free = square - mixed**2 / max(whole, 1e-12)
    # What the gain can make nearly all of says nothing.
    told = np.triu(free > 1e-3 * square, k=1)
    evidence = np.where(told, np.maximum(more, 0) ** 2 / np.where(told, free, 1), 0)
    first, last = np.unravel_index(int(np.argmax(evidence)), evidence.shape)
    return int(first), int(last), float(evidence[first, last])

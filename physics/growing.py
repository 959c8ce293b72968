"""Effects that become more, or less, in the course of a session: frames between renderings at three strengths."""

from collections.abc import Callable

import numpy as np


def between(degrees: np.ndarray, most: float, at: Callable[[float], np.ndarray]) -> np.ndarray:
    """(F, P, T) expected counts of F frames, of which an effect is `degrees` (F,) times as strong as is said.

    at: the counts of all of them where it is so many times as strong in all. most: the largest degree of any frame.
    Counts are taken along the parabola through those at none, half and all of `most`: exact where they go with the
    square of the strength, and off by its third power where they do not.
    """
    if most == 0:
        return at(0.0)
    part = (np.asarray(degrees, float) / most)[:, None, None]
    none, half, all_of_it = (at(most * share) for share in (0.0, 0.5, 1.0))
    mixed = (1 - part) * (1 - 2 * part) * none + 4 * part * (1 - part) * half + part * (2 * part - 1) * all_of_it
    return np.maximum(mixed, 0.0)

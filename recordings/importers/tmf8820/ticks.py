"""Times from the sensor's own counter."""

from typing import Any

import numpy as np

# Datasheet DS000693: the counter steps every 200 ns, is 32 bits wide, and its lowest bit says it is valid.
TICK_S = 200e-9
TICKS = 1 << 32


def tick_times_s(ticks: Any) -> np.ndarray | None:
    """(F,) seconds since the first frame from the counter's readings, over its wraps every 859 s.

    None where a reading is absent, no 32-bit number, not valid, or the same as the one before. Two frames
    more than 859 s apart cannot be told from two that are less.
    """
    try:
        ticks = np.asarray(ticks)
    except ValueError:
        return None
    if ticks.ndim != 1 or ticks.dtype.kind not in "iu" or not ((ticks > 0) & (ticks < TICKS)).all():
        return None
    steps = np.diff(ticks.astype(np.int64)) % TICKS
    if not (ticks & 1).all() or not steps.all():
        return None
    return np.concatenate([[0.0], np.cumsum(steps) * TICK_S])

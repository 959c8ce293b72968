"""How often frames were taken."""

import numpy as np

# The part of frames that stand closest.
CLOSE = 0.1
# Frames in bursts, far from each other, are looked at as if there were no more than so many.
MOST_FRAMES = 4096


def frame_interval_s(time_s: np.ndarray) -> float:
    """Seconds from frame to frame of a recording of which these, at times (F,) in order, are some; 0 of fewer than two.

    Frames that choose a model are some of all: neighbours among them are a frame apart or several. The closest tell.
    """
    if len(time_s) < 2:
        return 0.0
    return max(float(np.quantile(np.diff(time_s), CLOSE)), float(np.ptp(time_s)) / MOST_FRAMES)

"""What a histogram of photons cannot be, although every line of it is well formed.

A count is at most one for each laser shot: the datasheet (DS000693) says that 24 bits overflow only above 16384 kilo
iterations, 2^24 shots. No tighter bound is used. A channel joins about twenty SPADs, each of which may fire once or
more within a shot, so its bins can add up to more than the number of shots; each bin cannot hold more.

A digit that changed makes one cell jump alone: against the bins beside it, for the impulse response spans several, and
against itself a measurement ago. Light does neither: a pulse lifts the bins beside its peak, and what stays is no
jump. A cell may well be the darkest between two pulses, so it is too low only below all that is near, and below where
both its sides are falling.

At 900 counts a jump of 14 standard deviations is seen, beside pulses only more, in the first and the last bin none. Of
199,000 drawn measurements of ten channels, each of another scene of two pulses 1.5 bins wide and of any brightness, 2
were dropped; of 415 published ones of a TMF8820, none.
"""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

# A pulse 1.5 bins wide (full width at half maximum) that falls into the middle of a bin lifts it 2.7 times as far as
# the bins beside it, both alike; a published one of strong crosstalk, 4.6 times.
STEEPEST = 6.0
# Bins to each side in which a pulse ends, so that the lowest of them is the level without it.
NEAR = 6
# Bins of a time-to-digital converter are not quite of one width.
UNEVEN = 0.15
# How many standard deviations are beyond photon noise: one cell in a measurement of thousands, for years.
BEYOND = 8.0
# How far a pulse can rise between two bins that are empty by chance.
FEW = 40.0


def implausible(counts: np.ndarray, before: np.ndarray | None, shots: int | None) -> str | None:
    """Why (..., 128) counts cannot be what a sensor saw, None if they can.

    before: the measurement before, None if there is none. shots: of the laser, None where unknown.
    """
    if shots is not None and counts.max() > shots:
        return "a count above the number of laser shots"
    if before is not None and lone(counts, before).any():
        return "a cell jumped alone"
    return None


def lone(counts: np.ndarray, before: np.ndarray) -> np.ndarray:
    """Where a cell of (..., T) counts jumped beyond noise, against those beside it and itself in `before`."""
    now, then = counts.astype(np.float32), before.astype(np.float32)
    jumped = np.abs(now - then) > BEYOND * np.sqrt(now + then + 1)
    if not jumped.any():
        return jumped
    around = np.pad(now, [(0, 0)] * (now.ndim - 1) + [(NEAR, NEAR)], mode="reflect")
    left2, left, right, right2 = (around[..., NEAR + step :][..., : now.shape[-1]] for step in (-2, -1, 1, 2))
    lowest = sliding_window_view(around, NEAR, axis=-1).min(axis=-1)
    floor = np.minimum(lowest[..., : now.shape[-1]], lowest[..., -now.shape[-1] :])
    high = np.maximum(left, right)
    noise = np.sqrt(high + 1)
    lifted = np.maximum(high - floor - 3 * noise, 0)
    above = now > high * (1 + UNEVEN) + (STEEPEST - 1) * lifted + BEYOND * noise + FEW
    low = np.minimum(np.minimum(falling(left, left2), falling(right, right2)), floor)
    below = now < low * (1 - UNEVEN) - BEYOND * np.sqrt(low + 1)
    alone = jumped & (above | below)
    # The first and the last bin have a neighbour on one side only, and the rest of a pulse may lie outside.
    alone[..., [0, -1]] = False
    return alone


def falling(near: np.ndarray, next_to_it: np.ndarray) -> np.ndarray:
    """How low the cell after two that fall may be: a pulse falls faster with each bin."""
    return near * np.minimum(near / np.maximum(next_to_it, 1), 1) ** 3

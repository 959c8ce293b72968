"""Times of measurements, from the chip's clock where it says them, else from their numbers."""

import numpy as np


def times_s(ticks_s: np.ndarray, numbers: np.ndarray) -> tuple[np.ndarray, str | None]:
    """(F,) strictly increasing seconds since the first, and what had to be assumed, if anything.

    ticks_s: (F,) of the chip's clock, NaN where it is not valid. numbers: (F,) strictly increasing.
    """
    valid = np.isfinite(ticks_s)
    rising = valid.any() and (np.diff(ticks_s[valid]) > 0).all()
    if not rising or (valid.sum() < 2 and len(ticks_s) > 1):
        why = "the chip's clock is not valid or does not rise"
        return (numbers - numbers[0]).astype(float), f"timestamp_s: one measurement a second, as {why}"
    times = np.interp(numbers, numbers[valid], ticks_s[valid])
    # Before the first and after the last valid reading measurements are taken to come as often as between them.
    first, last = np.flatnonzero(valid)[[0, -1]]
    step = (ticks_s[last] - ticks_s[first]) / max(numbers[last] - numbers[first], 1)
    times[:first] = ticks_s[first] + step * (numbers[:first] - numbers[first])
    times[last + 1 :] = ticks_s[last] + step * (numbers[last + 1 :] - numbers[last])
    if valid.all():
        return times - times[0], None
    return times - times[0], f"timestamp_s: from its neighbours where the chip's clock is not valid ({(~valid).sum()})"

"""Where the highest pulse of a histogram is, as firmware finds it: the peak, and the middle of what is near it."""

import numpy as np
from scipy.signal import fftconvolve
from scipy.special import expit

from physics.arrivals import Arrivals
from physics.clock import Clock

# Light is of that pulse within so many standard deviations of a pulse, and a bin at least, but for a rim of this part,
# or of so many bins.
WITHIN, RIM, RIM_BINS = 3.0, 0.05, 1 / 8


def highest_turns(arrivals: Arrivals, clock: Clock, within: float = 1.0) -> np.ndarray:
    """(F, P, 1) bins from the start of the first to the mean nominal arrival of light in the highest pulse.

    within: part of that about the peak that is looked at; towards 0 it is the peak alone.
    """
    lattice, width_s = arrivals.lattice, clock.bin_width_s
    after_s, part = clock.pulse.time_s, clock.pulse.probability
    late_s = float(after_s @ part)
    near_s = within * max(WITHIN * float(np.sqrt((after_s - late_s) ** 2 @ part)), width_s)
    alone = np.diff(lattice.cumulative)[None, None]
    # The peak of a pulse is where its light comes but for how late the peak of a pulse alone is.
    peaks = _top(fftconvolve(arrivals.light, alone, axes=-1)) - _top(alone)
    peak_s = lattice.first_s + lattice.step_s * peaks
    knots_s = lattice.first_s + lattice.step_s * np.arange(lattice.size)
    rim_s = max(RIM * near_s, RIM_BINS * width_s)
    light = arrivals.light * expit((near_s - np.abs(knots_s - peak_s)) / rim_s)
    received = light.sum(axis=-1, keepdims=True)
    return np.where(received > 0, (light @ knots_s)[..., None] / np.where(received > 0, received, 1), peak_s) / width_s


def _top(heights: np.ndarray) -> np.ndarray:
    """(..., 1) place of the highest of (..., N), between its neighbours as a parabola has it."""
    at = np.clip(heights.argmax(axis=-1), 1, heights.shape[-1] - 2)[..., None]
    before, top, after = (np.take_along_axis(heights, at + by, axis=-1) for by in (-1, 0, 1))
    bend = 2 * top - before - after
    return at + np.where(bend > 0, (after - before) / (2 * np.where(bend > 0, bend, 1)), 0)

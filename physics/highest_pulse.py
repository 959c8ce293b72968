"""Where the highest pulse of a histogram is, as firmware finds it: the peak, and the middle of what is near it."""

import numpy as np
from scipy.signal import fftconvolve
from scipy.special import expit

from physics.arrivals import Arrivals
from physics.clock import Clock

# Light is of that pulse within so many standard deviations of a pulse, and a bin at least, but for a rim of this part.
WITHIN, RIM = 3.0, 0.05


def highest_turns(arrivals: Arrivals, clock: Clock) -> np.ndarray:
    """(F, P, 1) bins from the start of the first to the mean nominal arrival of light in the highest pulse."""
    lattice, width_s = arrivals.lattice, clock.bin_width_s
    after_s, part = clock.pulse.time_s, clock.pulse.probability
    late_s = float(after_s @ part)
    near_s = max(WITHIN * float(np.sqrt((after_s - late_s) ** 2 @ part)), width_s)
    registered = fftconvolve(arrivals.light, np.diff(lattice.cumulative)[None, None], axes=-1)
    begin_s = lattice.first_s + clock.pulse.edges[0] + lattice.step_s / 2
    peak_s = begin_s + lattice.step_s * _top(registered) - late_s
    knots_s = lattice.first_s + lattice.step_s * np.arange(lattice.size)
    light = arrivals.light * expit((1 - np.abs(knots_s - peak_s) / near_s) / RIM)
    received = light.sum(axis=-1, keepdims=True)
    return np.where(received > 0, (light @ knots_s)[..., None] / np.where(received > 0, received, 1), peak_s) / width_s


def _top(heights: np.ndarray) -> np.ndarray:
    """(..., 1) place of the highest of (..., N), between its neighbours as a parabola has it."""
    at = np.clip(heights.argmax(axis=-1), 1, heights.shape[-1] - 2)[..., None]
    before, top, after = (np.take_along_axis(heights, at + by, axis=-1) for by in (-1, 0, 1))
    bend = 2 * top - before - after
    return at + np.where(bend > 0, (after - before) / (2 * np.where(bend > 0, bend, 1)), 0)

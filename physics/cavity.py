"""Light that has gone round in a cavity about the target, which is the larger the farther the target is."""

import numpy as np
from scipy.special import gammainc

from physics.arrivals import delayed
from physics.clock import Clock

# Light is followed by so many steps over the whole window: it comes so broadly that finer ones are not seen.
STEPS = 256


def gone_round(light: np.ndarray, clock: Clock, late: float, breadth: float) -> np.ndarray:
    """(F, P, J) light by knot of the clock's lattice, each later by a part of its own time of flight.

    That part is gamma-distributed, of mean `late` and standard deviation `late` · `breadth`: exponential at a breadth
    of 1, as after many reflections of which each takes as long, near a normal distribution where it is small. What
    would come later than the last knot is lost. Light is given to the steps about it in proportion, so that the mean is
    exact, and what arrives is even over each of these.
    """
    lattice = clock.lattice
    frames, zones, size = light.shape
    wide = -(-size // STEPS)
    zero = (np.broadcast_to(np.asarray(clock.time_zero_s, float), (frames, zones)) - lattice.first_s) / lattice.step_s
    flown = delayed(light, -zero)
    # Hats about the centres of steps, at 0, 1, 2… times `wide`: the knots of each in proportion to how near they are.
    steps, part = -(-size // wide), np.arange(wide) / wide
    knots = np.pad(flown, ((0, 0), (0, 0), (0, steps * wide - size))).reshape(frames, zones, steps, wide)
    by_step = knots @ (1 - part)
    by_step[..., 1:] += (knots @ part)[..., :-1]
    later = by_step[..., 1:] @ _shares_later(steps, late, breadth)
    even = np.repeat(later / wide, wide, axis=-1)[..., :size]
    # Knots of a step lie after its beginning, half a step before its centre.
    return delayed(even, zero - (wide - 1) / 2)


def _shares_later(steps: int, late: float, breadth: float) -> np.ndarray:
    """(steps - 1, steps) what light of each step but 0 gives to every step, each as wide as a step about its time."""
    shape = 1 / breadth**2
    flown = np.arange(1.0, steps)[:, None]
    until = (np.arange(steps + 1.0) - 0.5 - flown) / flown
    return np.diff(gammainc(shape, np.maximum(until, 0) * shape / late), axis=-1)

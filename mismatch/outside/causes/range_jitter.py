"""The pulse broadens in proportion to range: noise of the clock's rate."""

import numpy as np
from scipy.special import ndtr

from physics.effect import Effect, Parameter, Values
from physics.rendering import Rendering


class RangeJitter(Effect):
    """Each photon's time since the laser fired is off by a normal deviate of standard deviation `rate` · that time.

    Applied to histograms of light: what is in a bin is spread over others as a normal law about its centre, of the
    variance that is added to one of a twelfth of a bin squared, its own.
    """

    id = "range_jitter"
    acts_on = "detector"
    order = -90  # Light alone, before detectors.
    sentence = "pulses are the broader the longer light was under way"
    forms = (("rate",),)
    parameters = (
        Parameter(
            "rate",
            unit="1",
            low=0.0,
            high=0.2,
            start=0.02,
            vanishes_at=0.0,
            power=2.0,
            sentence="Standard deviation over time of flight.",
        ),
    )

    def expected(self, values: Values, rendering: Rendering) -> np.ndarray:
        """Counts with light spread."""
        clock, bins = rendering.clock, rendering.expected.shape[-1]
        light = rendering.expected - rendering.background
        centres = np.arange(bins) + 0.5
        zero = float(np.mean(clock.time_zero_s)) / clock.bin_width_s
        sigma = values["rate"] * np.maximum(centres - zero, 0)
        return np.maximum(light @ _spread(sigma, bins) + rendering.background, 0)


def _spread(sigma: np.ndarray, bins: int) -> np.ndarray:
    """(T, T) part of each bin's light that goes to each bin, of standard deviations (T,) in bins.

    The triangle law of a bin seen through a bin is taken for a normal law of its variance, a sixth, on either side of
    the division, so that a spread of 0 is none.
    """
    apart = np.arange(bins)[None, :] - np.arange(bins)[:, None]
    own = np.sqrt(1 / 6)
    wide = np.sqrt(sigma[:, None] ** 2 + own**2)

    def bell(width: np.ndarray | float) -> np.ndarray:
        return ndtr((apart + 0.5) / width) - ndtr((apart - 0.5) / width)

    return np.eye(bins) + bell(wide) - bell(own)


effect = RangeJitter()

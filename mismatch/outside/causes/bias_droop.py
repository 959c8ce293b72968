"""Detectors of all zones share a bias, which droops with the light on any of them and comes back in a while."""

import numpy as np
from scipy.signal import lfilter

from physics.effect import Effect, Parameter, Values
from physics.rendering import Rendering

LEAST = 1e-12


class BiasDroop(Effect):
    """Counts of all zones times exp(-droop · e), with e what the whole array counted in earlier bins of the histogram.

    Each count before weighs exp(-t / recovery) of how long ago it was; e is 1 where that is most in any frame. A SPAD's
    chance to count goes with its bias above breakdown, which avalanches draw down and a resistor restores.
    """

    id = "bias_droop"
    acts_on = "detector"
    order = 80  # All that a zone counts, before histograms are mixed.
    sentence = "all zones are less sensitive for a while after light on any of them"
    forms = (("droop", "recovery"),)
    parameters = (
        Parameter("droop", "1", -0.2, 5.0, 0.05, "Logarithm of the sensitivity that is lost at most.", vanishes_at=0.0),
        Parameter("recovery", "s", 1e-10, 1e-6, 5e-9, "In which the bias comes back.", tries=(2e-9, 6e-9, 2e-8)),
    )

    def expected(self, values: Values, rendering: Rendering) -> np.ndarray:
        """Counts at the bias that is left."""
        if not values["droop"]:
            return rendering.expected
        kept = np.exp(-rendering.clock.bin_width_s / values["recovery"])
        drawn = lfilter([0.0, 1.0], [1.0, -kept], rendering.expected.sum(axis=1), axis=-1)
        drawn /= max(float(drawn.max()), LEAST)
        return rendering.expected * np.exp(-values["droop"] * drawn)[:, None]


effect = BiasDroop()

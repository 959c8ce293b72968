"""A front end that is coupled by a capacitor dips below its base line after each pulse."""

import numpy as np
from scipy.signal import lfilter

from physics.effect import Effect, Parameter, Values
from physics.rendering import Rendering


class Undershoot(Effect):
    """Counts less `lost` times the light of earlier bins, each weighed by exp(-t / tau) of how long ago it was.

    The weights' sum over a long time is 1, so that `lost` is the area of the dip over that of the pulse: it is 1 where
    nothing of direct current passes. No bin holds less than nothing.
    """

    id = "undershoot"
    acts_on = "detector"
    order = 70  # What is counted of all light, before anything is shared between zones.
    sentence = "the base line dips after each pulse, in proportion to it"
    forms = (("lost", "tau"),)
    parameters = (
        Parameter("lost", "1", 0.0, 3.0, 0.05, "Area of the dip over that of the pulse.", vanishes_at=0.0),
        Parameter("tau", "s", 1e-10, 1e-6, 3e-9, "In which the base line comes back.", tries=(1e-9, 3e-9, 1e-8)),
    )

    def expected(self, values: Values, rendering: Rendering) -> np.ndarray:
        """Counts with a base line that dips."""
        if not values["lost"]:
            return rendering.expected
        light = rendering.expected - np.minimum(rendering.background, rendering.expected)
        kept = np.exp(-rendering.clock.bin_width_s / values["tau"])
        before = lfilter([0.0, 1 - kept], [1.0, -kept], light, axis=-1)
        return np.maximum(rendering.expected - values["lost"] * before, 0)


effect = Undershoot()

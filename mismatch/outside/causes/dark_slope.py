"""The dark level changes along the histogram."""

import numpy as np

from physics.effect import Effect, Parameter, Values
from physics.rendering import Rendering


class DarkSlope(Effect):
    """Counts that no light sent fall as exp(-rate · t), or rise as t^power, t from 0 at the window's begin to 1.

    A supply that recovers after the laser has fired, or one that tires. A pedestal is as high everywhere.
    """

    id = "dark_slope"
    acts_on = "detector"
    order = -80
    sentence = "counts that no light sent rise or fall along the histogram"
    forms = (("falling", "rate"), ("rising", "power"))
    parameters = (
        *(
            Parameter(
                name,
                unit="counts",
                low=0.0,
                high=1e9,
                start=1.0,
                vanishes_at=0.0,
                axis="zone",
                sentence=f"Per bin, at the window's {end}.",
            )
            for name, end in (("falling", "begin"), ("rising", "end"))
        ),
        Parameter("rate", unit="1", low=0.3, high=30.0, start=3.0, sentence="E-foldings over the window."),
        Parameter("power", unit="1", low=0.3, high=5.0, start=1.0, sentence="Of time since the window's begin."),
    )

    def background(self, values: Values, rendering: Rendering) -> np.ndarray:
        """Dark counts with the slope: (P, T), or as background and counts broadcast."""
        t = (np.arange(rendering.clock.bins) + 0.5) / rendering.clock.bins
        falling, rising = (np.atleast_1d(values[name])[:, None] for name in ("falling", "rising"))
        return rendering.background + falling * np.exp(-values["rate"] * t) + rising * t ** values["power"]


effect = DarkSlope()

"""Counts go by a power of the light."""

import numpy as np

from physics.effect import Effect, Parameter, Values
from physics.rendering import Rendering


class PowerLaw(Effect):
    """Where n counts should be there are n (n/`full`)^`more`.

    Histograms that are compressed for the way and expanded with another exponent, detectors whose sensitivity goes
    with the rate. A gain is the same at all rates.
    """

    id = "power_law"
    acts_on = "detector"
    order = 75
    sentence = "counts go by a power of the light"
    forms = (("more", "full"),)
    parameters = (
        Parameter("more", "1", -0.5, 0.5, 0.01, "By how much the power differs from 1.", vanishes_at=0.0),
        Parameter("full", "counts", 1.0, 1e9, 1e3, "Counts that are what they should be."),
    )

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """The largest count, and one that is usual."""
        return [{"full": max(1.0, float(of(expected)))} for of in (np.max, np.median)]

    def expected(self, values: Values, rendering: Rendering) -> np.ndarray:
        """Counts to that power; none stay none."""
        counts = np.maximum(rendering.expected, 0)
        return counts * np.where(counts > 0, counts / values["full"], 1) ** values["more"]


effect = PowerLaw()

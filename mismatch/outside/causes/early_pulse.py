"""The laser fires a weak pulse in advance."""

import numpy as np
from scipy.constants import speed_of_light

from physics.arrivals import Arrivals
from physics.effect import Effect, Parameter, Values
from physics.rendering import Rendering
from physics.replicas import replicas


class EarlyPulse(Effect):
    """Everything is seen once more, `ahead` seconds earlier and `part` as strong, at all ranges alike.

    A sheet of glass in front would be the brighter the nearer it is.
    """

    id = "early_pulse"
    acts_on = "scene"
    sentence = "a weak copy of the signal comes a fixed time before it, at all ranges alike"
    forms = (("part", "ahead"),)
    parameters = (
        Parameter("part", unit="1", low=0.0, high=1.0, start=0.01, vanishes_at=0.0, sentence="Of the main pulse."),
        Parameter("ahead", unit="s", low=1e-10, high=2e-8, start=1e-9, sentence="How much earlier."),
    )

    def arrivals(self, values: Values, rendering: Rendering) -> Arrivals:
        """Light, and its forerunner."""
        light = rendering.arrivals
        early = light.delayed(-values["ahead"])
        return type(light)(light.light + values["part"] * early.light, light.lattice, light.bins)

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """Where most of an excess is a replica in front."""
        found = [-2 * one.spacing_m / speed_of_light for one in replicas(excess, expected, rendering, 0.0)]
        ahead, part = self.parameter("ahead"), self.parameter("part")
        return [{"part": part.start, "ahead": min(s, ahead.high)} for s in found if s >= ahead.low]


effect = EarlyPulse()

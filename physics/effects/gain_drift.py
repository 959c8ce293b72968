"""`gain_drift`: laser power or sensitivity changes over the session."""

import numpy as np

from physics.effect import Effect, LookAlike, Parameter, Values
from physics.rendering import Rendering


class GainDrift(Effect):
    """After t seconds there are exp(rate · t) times the counts, background included: a factor that stays positive."""

    id = "gain_drift"
    acts_on = "detector"
    sentence = "Laser power or sensitivity changes in the course of the session, and all counts with it."
    look_alikes = (
        LookAlike("reflectance_map", "Look at one surface again at the end: drift goes with time, not with the place."),
        LookAlike("pile_up", "Compare dark and bright targets in one frame: drift scales both, pile-up the bright."),
        LookAlike("zone_gain", "Repeat the first frame at the end of the session: a gain of zones is what it was."),
    )
    parameters = (
        Parameter(
            "rate",
            unit="1/s",
            low=-10.0,
            high=10.0,
            start=0.01,
            vanishes_at=0.0,
            sentence="Relative change of all counts per second, compounded.",
        ),
    )

    def expected(self, values: Values, rendering: Rendering) -> np.ndarray:
        """Every frame times the factor of its time."""
        return rendering.expected * np.exp(values["rate"] * rendering.light.time_s)[:, None, None]


effect = GainDrift()

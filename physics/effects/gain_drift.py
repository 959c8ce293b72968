"""`gain_drift`: laser power or sensitivity changes over the session."""

import numpy as np

from physics.effect import Effect, LookAlike, Parameter, Values
from physics.rendering import Rendering


class GainDrift(Effect):
    """After t seconds there are exp(rate·t + warmup·exp(-t/τ)) times the counts, background included.

    A factor that stays positive; a laser that warms up settles exponentially.
    """

    id = "gain_drift"
    acts_on = "detector"
    sentence = "Laser power or sensitivity changes in the course of the session, and all counts with it."
    look_alikes = (
        LookAlike("reflectance_map", "Look at one surface again at the end: drift goes with time, not with the place."),
        LookAlike("pile_up", "Compare dark and bright targets in one frame: drift scales both, pile-up the bright."),
        LookAlike("zone_gain", "Repeat the first frame at the end of the session: a gain of zones is what it was."),
    )
    forms = (("rate",), ("warmup", "tau"))
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
        Parameter(
            "warmup",
            unit="1",
            low=-2.0,
            high=2.0,
            start=0.05,
            vanishes_at=0.0,
            sentence="Logarithm of the factor at the start of the session, over that in the end.",
        ),
        Parameter(
            "tau",
            unit="s",
            low=1e-2,
            high=1e4,
            start=1.0,
            tries=(0.3, 1.0, 3.0, 30.0),
            sentence="Time constant of the warming up.",
        ),
    )

    def expected(self, values: Values, rendering: Rendering) -> np.ndarray:
        """Every frame times the factor of its time."""
        time_s = rendering.light.time_s
        change = values["rate"] * time_s + values["warmup"] * np.exp(-time_s / values["tau"])
        return rendering.expected * np.exp(change)[:, None, None]


effect = GainDrift()

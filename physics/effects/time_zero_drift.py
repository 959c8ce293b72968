"""`time_zero_drift`: the delay of the sensor changes over the session, as it warms up."""

import numpy as np

from physics.arrivals import Arrivals
from physics.effect import Effect, LookAlike, Parameter, Values
from physics.rendering import Rendering


class TimeZeroDrift(Effect):
    """After t seconds all zones register light later by rate·t + curve·t² + warmup·(1 - exp(-t/τ)).

    Where that is negative they do so earlier. Light from beyond the window, which a negative delay would bring into its
    last bins, is not followed.
    """

    id = "time_zero_drift"
    acts_on = "time"
    sentence = "All light is registered later and later, or earlier and earlier, in the course of the session."
    look_alikes = (
        LookAlike("time_zero_offset", "Repeat the first frame at the end of the session: drift shows, an offset not."),
        LookAlike("time_lag", "Hold sensor and scene still: drift goes on, a lag has nothing to show."),
        LookAlike("gain_drift", "Hold the target still and sum over bins: a drifting delay leaves the sum as it is."),
    )
    forms = (("rate",), ("warmup", "tau"), ("rate", "curve"))
    parameters = (
        Parameter(
            "rate",
            unit="s/s",
            low=-1e-8,
            high=1e-8,
            start=1e-11,
            vanishes_at=0.0,
            sentence="By how much the delay grows in a second.",
        ),
        Parameter(
            "curve",
            unit="s/s^2",
            low=-1e-8,
            high=1e-8,
            start=1e-12,
            vanishes_at=0.0,
            sentence="Half of what the rate grows by in a second.",
        ),
        Parameter(
            "warmup",
            unit="s",
            low=-5e-9,
            high=5e-9,
            start=5e-11,
            vanishes_at=0.0,
            sentence="Delay that comes to be as the sensor warms up.",
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

    def arrivals(self, values: Values, rendering: Rendering) -> Arrivals:
        """All light, delayed by what its frame's time makes."""
        time_s = rendering.light.time_s[:, None]
        warm = -np.expm1(-time_s / values["tau"])
        return rendering.arrivals.delayed(
            (values["rate"] + values["curve"] * time_s) * time_s + values["warmup"] * warm
        )


effect = TimeZeroDrift()

"""`time_zero_drift`: the delay of the sensor changes over the session, as it warms up."""

import numpy as np

from physics.arrivals import Arrivals
from physics.effect import Effect, LookAlike, Parameter, Values
from physics.rendering import Rendering

# So many times what it changes by is more than a drift can be at its start.
OFFSET = 2.0


class TimeZeroDrift(Effect):
    """After t seconds all zones register light later by at_start + rate·t + curve·t² + warmup·(1 - exp(-t/τ)).

    What it is at the start is not 0 where time zero was measured on a sensor as warm as it is later on. Where that is
    negative they do so earlier. Light from beyond the window, which a negative delay would bring into its last bins,
    is not followed.
    """

    id = "time_zero_drift"
    acts_on = "time"
    sentence = "All light is registered later and later, or earlier and earlier, in the course of the session."
    look_alikes = (
        LookAlike("time_zero_offset", "Repeat the first frame at the end of the session: drift shows, an offset not."),
        LookAlike("time_lag", "Hold sensor and scene still: drift goes on, a lag has nothing to show."),
        LookAlike("gain_drift", "Hold the target still and sum over bins: a drifting delay leaves the sum as it is."),
    )
    forms = (
        ("rate",),
        ("warmup", "tau"),
        ("rate", "curve"),
        ("rate", "at_start"),
        ("warmup", "tau", "at_start"),
        ("rate", "curve", "at_start"),
    )
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
        Parameter(
            "at_start",
            unit="s",
            low=-5e-9,
            high=5e-9,
            start=1e-11,
            vanishes_at=0.0,
            sentence="Delay in the first frame.",
        ),
    )

    def arrivals(self, values: Values, rendering: Rendering) -> Arrivals:
        """All light, delayed by what its frame's time makes."""
        return rendering.arrivals.delayed(values["at_start"] + _since(values, rendering.light.time_s)[:, None])

    def strained(self, values: Values, rendering: Rendering) -> bool:
        """A delay that is there at the start and hardly changes is an offset."""
        changed = np.ptp(_since(values, rendering.light.time_s))
        return bool(abs(values["at_start"]) > OFFSET * changed)


def _since(values: Values, time_s: np.ndarray) -> np.ndarray:
    """(F,) delay, seconds, that has come to be since the start."""
    return (values["rate"] + values["curve"] * time_s) * time_s + values["warmup"] * -np.expm1(-time_s / values["tau"])


effect = TimeZeroDrift()

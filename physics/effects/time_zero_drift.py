"""`time_zero_drift`: the delay of the sensor changes over the session, as it warms up."""

import numpy as np

from physics.arrivals import Arrivals
from physics.effect import Effect, LookAlike, Parameter, Values
from physics.rendering import Rendering
from physics.walk import BETWEEN, LEVELS, walk_parameters, walk_starts, walked


class TimeZeroDrift(Effect):
    """After t seconds all zones register light later by d(t) - d(z), d(t) = rate·t + curve·t² + warmup·(1 - exp(-t/τ)).

    z is when time zero was right: at the start, or later, where it was measured on a sensor as warm as it is then. A
    delay that is never zero within the session is an offset, and a drift beside it. Where it is negative light is
    registered earlier. What follows no formula walks or jumps beside that: a spline through 0 at the start and levels
    at even times, and a jump (`physics.walk`). Each zone's rate may be its own. Light from beyond the window, which a
    negative delay would bring into its last bins, is not followed.
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
        ("rate", "zero_at"),
        ("warmup", "tau", "zero_at"),
        ("rate", "curve", "zero_at"),
        LEVELS,
        (*LEVELS, *BETWEEN),
        (*LEVELS, "zero_at"),
        (*LEVELS, *BETWEEN, "zero_at"),
        ("jump",),
    )
    parameters = (
        Parameter(
            "rate",
            unit="s/s",
            low=-1e-8,
            high=1e-8,
            start=1e-11,
            vanishes_at=0.0,
            axis="zone",
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
            tries=(0.5, 5.0),
            sentence="Time constant of the warming up.",
        ),
        Parameter(
            "zero_at",
            unit="s",
            low=0.0,
            high=1e5,
            start=0.0,
            tries=(0.1,),
            sentence="When the delay is zero, within the session.",
        ),
        *walk_parameters("s", 5e-9, 2e-11),
    )

    def moves_light(self, values: Values) -> bool:
        """See `Effect`."""
        return any(np.any(values[p.name]) for p in self.parameters if p.vanishes_at == 0)

    def arrivals(self, values: Values, rendering: Rendering) -> Arrivals:
        """All light, delayed by what its frame's time makes."""
        time_s = rendering.light.time_s
        right = np.minimum(values["zero_at"], time_s.max())
        return rendering.arrivals.delayed(_since(values, time_s[:, None]) - _since(values, right))

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """Time zero right in the middle of the session; levels as long as it, beside that too; the clearest jump."""
        time_s, mean = rendering.light.time_s, np.maximum(expected, 1)
        rise = np.gradient(expected, axis=-1) / rendering.clock.bin_width_s
        weight = (rise**2 / mean).sum(axis=(1, 2))
        late_s = -(rise * excess / mean).sum(axis=(1, 2)) / np.maximum(weight, 1e-12)
        walks = walk_starts({p.name: p for p in self.parameters}, time_s, late_s, weight)
        middle = {"zero_at": float(time_s.mean())}
        return [middle, *walks, *(walk | middle for walk in walks if "every" in walk)]


def _since(values: Values, time_s: np.ndarray | float) -> np.ndarray | float:
    """Delay, seconds, that has come to be since the start: of each time, (F, 1) or a number, and zone."""
    warmed = values["warmup"] * -np.expm1(-time_s / values["tau"])
    return (values["rate"] + values["curve"] * time_s) * time_s + warmed + walked(values, time_s)


effect = TimeZeroDrift()

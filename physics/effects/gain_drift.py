"""`gain_drift`: laser power or sensitivity changes over the session."""

import numpy as np

from physics.effect import Effect, LookAlike, Parameter, Values
from physics.rendering import Rendering
from physics.walk import BETWEEN, LEVELS, walk_parameters, walk_starts, walked

# Most that the logarithm of gain may change.
MOST = 50.0
# What settles in a session has lost so much of itself by its end.
SETTLED = 0.3


class GainDrift(Effect):
    """After t seconds there are g times the counts of laser light, and

        g = exp(d(t) - d(zero_at) + warmup·exp(-t/τ)), d(t) = rate·t + curve·t² + w(t)

    A factor that stays positive; a laser that warms up settles exponentially. What follows no formula walks or jumps:
    w(t) is a spline through 0 at the start and levels at even times, and a jump (`physics.walk`). The background has
    g(t)^background times its counts: the laser's power leaves it as it is (0), the detector's sensitivity drifts for
    both alike (1). At `zero_at`, the start or later within the session, the background is as it was recorded but for a
    jump, and detectors of zones that drift at different rates are alike.
    """

    id = "gain_drift"
    acts_on = "detector"
    sentence = "Laser power or sensitivity changes in the course of the session, and the counts with it."
    look_alikes = (
        LookAlike("reflectance_map", "Look at one surface again at the end: drift goes with time, not with the place."),
        LookAlike("pile_up", "Compare dark and bright targets in one frame: drift scales both, pile-up the bright."),
        LookAlike("zone_gain", "Repeat the first frame at the end of the session: a gain of zones is what it was."),
    )
    forms = (
        ("rate",),
        ("rate", "background"),
        ("warmup", "tau"),
        ("warmup", "tau", "background"),
        ("rate", "curve", "background"),
        (*LEVELS, "background"),
        (*LEVELS, *BETWEEN, "background"),
        ("jump", "background"),
        ("rate", "curve", "zero_at", "background"),
        (*LEVELS, "zero_at", "background"),
        (*LEVELS, *BETWEEN, "zero_at", "background"),
    )
    richer = forms[-3:]
    parameters = (
        Parameter(
            "rate",
            unit="1/s",
            low=-10.0,
            high=10.0,
            start=0.01,
            vanishes_at=0.0,
            axis="zone",
            sentence="Relative change of the counts per second, compounded.",
        ),
        Parameter(
            "curve",
            unit="1/s^2",
            low=-10.0,
            high=10.0,
            start=1e-3,
            vanishes_at=0.0,
            sentence="Half of what the rate changes by in a second.",
        ),
        Parameter(
            "warmup",
            unit="1",
            low=-2.0,
            high=2.0,
            start=0.05,
            vanishes_at=0.0,
            axis="zone",
            sentence="Logarithm of the factor at the start of the session, over that in the end.",
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
        Parameter("zero_at", "s", 0.0, 1e5, 0.0, "When it is nothing, but for warming up.", tries=(0.1,)),
        *walk_parameters("1", 5.0, 0.05),
        Parameter(
            "background",
            unit="1",
            low=0.0,
            high=1.0,
            start=0.0,
            tries=(0.0, 1.0),
            sentence="Share of the drift that the background has: 0 where the laser drifts, 1 where the detector does.",
        ),
    )

    def expected(self, values: Values, rendering: Rendering) -> np.ndarray:
        """Signal and background of every frame times the factors of its time."""
        time_s = rendering.light.time_s[:, None, None]
        right = min(values["zero_at"], time_s.max())
        rate, warmup = (np.atleast_1d(values[name])[:, None] for name in ("rate", "warmup"))
        change = rate * (time_s - right) + values["curve"] * (time_s**2 - right**2)
        change = change + walked(values, time_s) - walked(values | {"jump": 0.0}, np.array(right))
        # No laser changes by more than this; beyond, numbers overflow.
        change = change + warmup * np.exp(-time_s / values["tau"])
        change = np.clip(change, -MOST, MOST)
        # Of what an effect before this one has taken away there cannot be more than there is.
        background = np.minimum(rendering.background, rendering.expected)
        signal = rendering.expected - background
        return signal * np.exp(change) + background * np.exp(values["background"] * change)

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """Levels that last as long as the session, and the jump that frames' brightness shows most."""
        signal, mean = np.maximum(expected - rendering.background, 0), np.maximum(expected, 1)
        weight = (signal**2 / mean).sum(axis=(1, 2))
        height = (signal * excess / mean).sum(axis=(1, 2)) / np.maximum(weight, 1e-12)
        return walk_starts({p.name: p for p in self.parameters}, rendering.light.time_s, height, weight)

    def strained(self, values: Values, rendering: Rendering) -> bool:
        """A warming up that has hardly begun when the session ends is another level, not a drift."""
        lost = -np.expm1(-np.ptp(rendering.light.time_s) / values["tau"])
        return bool(np.any(values["warmup"])) and lost < SETTLED


effect = GainDrift()

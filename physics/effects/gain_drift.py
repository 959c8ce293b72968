"""`gain_drift`: laser power or sensitivity changes over the session."""

import numpy as np
from scipy.interpolate import CubicSpline

from physics.effect import Effect, LookAlike, Parameter, Values
from physics.rendering import Rendering

# Most that the logarithm of gain may change.
MOST = 50.0
# What settles in a session has lost so much of itself by its end.
SETTLED = 0.3
# A drift of any shape has so many levels, and as many halfway to each.
LEVELS = tuple(f"level_{k}" for k in range(1, 7))
BETWEEN = tuple(f"between_{k}" for k in range(1, 7))


class GainDrift(Effect):
    """After t seconds there are g = exp(rate·t + curve·t² + warmup·exp(-t/τ) + w(t)) times the counts of laser light.

    A factor that stays positive; a laser that warms up settles exponentially. One that walks does as w(t) says, a
    cubic spline through 0 at the start and level_k after k times `every` seconds; halfway to each it is between_k above
    the mean of the levels before and after. From the last level on it stays. The background has g(t)^background times
    its counts: the laser's power leaves it as it is (0), the detector's sensitivity drifts for both alike (1).
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
    )
    parameters = (
        Parameter(
            "rate",
            unit="1/s",
            low=-10.0,
            high=10.0,
            start=0.01,
            vanishes_at=0.0,
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
        *(Parameter(f"level_{k}", "1", -5.0, 5.0, 0.05, f"Level {k}.", vanishes_at=0.0) for k in range(1, 7)),
        *(Parameter(f"between_{k}", "1", -5.0, 5.0, 0.05, f"Before level {k}.", vanishes_at=0.0) for k in range(1, 7)),
        Parameter("every", "s", 1e-3, 1e5, 1e-3, "Time from one level to the next, as long as the session says."),
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
        change = (values["rate"] + values["curve"] * time_s) * time_s
        # No laser changes by more than this; beyond, numbers overflow.
        change = change + values["warmup"] * np.exp(-time_s / values["tau"]) + _walk(values, time_s)
        change = np.clip(change, -MOST, MOST)
        # Of what an effect before this one has taken away there cannot be more than there is.
        background = np.minimum(rendering.background, rendering.expected)
        signal = rendering.expected - background
        return signal * np.exp(change) + background * np.exp(values["background"] * change)

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """Levels that last as long as the session."""
        every = float(np.ptp(rendering.light.time_s)) / len(LEVELS)
        first = {LEVELS[0]: self.parameter(LEVELS[0]).start}
        return [first | {"every": every}] if every >= self.parameter("every").low else []

    def strained(self, values: Values, rendering: Rendering) -> bool:
        """A warming up that has hardly begun when the session ends is another level, not a drift."""
        lost = -np.expm1(-np.ptp(rendering.light.time_s) / values["tau"])
        return bool(values["warmup"]) and lost < SETTLED


def _walk(values: Values, time_s: np.ndarray) -> np.ndarray:
    """Logarithm of the factor of a drift of any shape, at times of any shape."""
    level = np.array([0.0, *(values[name] for name in LEVELS)])
    between = np.array([values[name] for name in BETWEEN])
    if not (level.any() or between.any()):
        return np.zeros(time_s.shape)
    heights = np.zeros(2 * len(LEVELS) + 1)
    heights[::2], heights[1::2] = level, (level[1:] + level[:-1]) / 2 + between
    at = np.clip(2 * time_s / values["every"], 0, len(heights) - 1)
    return CubicSpline(np.arange(len(heights)), heights, bc_type="natural")(at)


effect = GainDrift()

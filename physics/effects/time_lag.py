"""`time_lag`: LiDAR and camera do not look at the same time."""

import numpy as np

from physics.arrivals import arrivals
from physics.effect import Effect, LookAlike, Parameter, Values
from physics.light import Light
from physics.light_between import around, from_neighbours, light_at
from physics.rendering import Rendering


class TimeLag(Effect):
    """The LiDAR sees the scene lag + skew·t seconds after the camera's image of its frame, before it where negative.

    t is the time since the session began: two clocks that do not agree run apart.

    What it sees then is taken pixel by pixel from the two frames around that time, range and strength linear in
    between; where an edge passes, part of the light of either (`light_at`). What it sees before the first frame and
    after the last nobody knows: nothing moves, or all moves on as it did, by the part `beyond`.
    """

    id = "time_lag"
    acts_on = "time"
    order = 9  # It concerns all that light has met by then.
    sentence = "The LiDAR measures somewhat later or earlier than the camera takes the image of its frame."
    look_alikes = (
        LookAlike("time_zero_drift", "Hold sensor and scene still: drift goes on, a lag has nothing to show."),
        LookAlike("footprint_shift", "Hold sensor and scene still: a shift stays, a lag has nothing to show."),
        LookAlike("parallax", "Hold sensor and scene still: parallax stays, a lag has nothing to show."),
    )
    forms = (("lag",), ("skew",), ("lag", "skew"), ("lag", "beyond"))
    richer = forms[-1:]
    parameters = (
        Parameter(
            "lag",
            unit="s",
            low=-2.0,
            high=2.0,
            start=0.05,
            vanishes_at=0.0,
            tries=(-0.05, 0.05),
            sentence="How much later than the camera the LiDAR looks.",
        ),
        Parameter("skew", "1", -0.5, 0.5, 0.01, "Seconds by which that grows in a second.", vanishes_at=0.0),
        Parameter("beyond", "1", 0.0, 1.0, 0.0, "How far things move on before the first frame and after the last."),
    )

    def reach(self, values: Values) -> tuple[float, float]:
        """Seconds before and after a frame from which its light comes."""
        if values["skew"]:
            return np.inf, np.inf
        return max(-values["lag"], 0.0), max(values["lag"], 0.0)

    def light(self, values: Values, rendering: Rendering) -> Light:
        """What the scene sends back at the LiDAR's times; the frames keep theirs."""
        if values["lag"] == 0 and values["skew"] == 0:
            return rendering.light
        time_s = np.asarray(rendering.light.time_s)
        return light_at(rendering.light, time_s + values["lag"] + values["skew"] * time_s, values["beyond"])

    def unseen(self, values: Values, rendering: Rendering) -> float:
        """What interpolation is off, as that of frames which were seen tells.

        On a curve it is off by x·(1 - x) of what it would be halfway between frames twice as far apart, with x the part
        of the way; its deviance goes with the square (the remainder of linear interpolation, Abramowitz and Stegun
        25.2.1).
        """
        light, times = rendering.light, np.asarray(rendering.light.time_s, float)
        lower, upper, part = around(times, times + values["lag"] + values["skew"] * times, 0.0)
        way = part * (1 - part)
        if not way.any():
            return 0.0
        counts, guessed = (
            rendering.gain * arrivals(seen, rendering.footprints, rendering.clock).binned()
            for seen in (light, from_neighbours(light))
        )
        off = ((guessed - counts) ** 2 / np.maximum(counts + rendering.background, 1)).sum(axis=(1, 2))
        return float((way**2 * (off[lower] + off[upper]) / 2).sum())


effect = TimeLag()

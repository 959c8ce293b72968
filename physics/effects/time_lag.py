"""`time_lag`: LiDAR and camera do not look at the same time."""

import numpy as np

from physics.effect import Effect, LookAlike, Parameter, Values
from physics.light import Light
from physics.light_between import light_at
from physics.rendering import Rendering


class TimeLag(Effect):
    """The LiDAR sees the scene lag + skew·t seconds after the camera's image of its frame, before it where negative.

    t is the time since the session began: two clocks that do not agree run apart.

    What it sees then is taken pixel by pixel from the two frames around that time, range and strength linear in
    between; where an edge passes, part of the light of either (`light_at`). Before the first frame and after the last
    nothing moves.
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
    forms = (("lag",), ("skew",), ("lag", "skew"))
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
        return light_at(rendering.light, time_s + values["lag"] + values["skew"] * time_s)


effect = TimeLag()

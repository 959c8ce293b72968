"""`time_zero_offset`: signals of a zone take longer through the chip than was assumed."""

import numpy as np

from physics.arrivals import Arrivals
from physics.effect import Effect, LookAlike, Parameter, Values
from physics.rendering import Rendering


class TimeZeroOffset(Effect):
    """Everything a zone registers is late, or early where negative, by the same time.

    Light from beyond the window, which a negative delay would bring into its last bins, is not followed.
    """

    id = "time_zero_offset"
    acts_on = "time"
    sentence = "All light of a zone is registered later, or earlier, by the same time."
    look_alikes = (
        LookAlike("bin_width_error", "Step the target in range: an offset stays, an error of the clock grows."),
        LookAlike("time_zero_drift", "Repeat the first frame at the end of the session: an offset is what it was."),
        LookAlike("range_walk", "Swap a white target for a black one: an offset stays, range walk changes."),
    )
    parameters = (
        # Delays between the zones of such sensors are about 50 ps either way.
        Parameter(
            "delay",
            unit="s",
            low=-2e-9,
            high=2e-9,
            start=5e-11,
            vanishes_at=0.0,
            axis="zone",
            sentence="How much later than assumed light is registered.",
        ),
    )

    def moves_light(self, values: Values) -> bool:
        """See `Effect`."""
        return bool(np.any(values["delay"]))

    def arrivals(self, values: Values, rendering: Rendering) -> Arrivals:
        """All light of each zone, delayed."""
        return rendering.arrivals.delayed(np.atleast_1d(values["delay"]))


effect = TimeZeroOffset()

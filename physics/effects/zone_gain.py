"""`zone_gain`: zones are more or less sensitive than their response maps say."""

from dataclasses import replace

import numpy as np

from physics.arrivals import Arrivals
from physics.effect import Effect, LookAlike, Parameter, Values
from physics.rendering import Rendering


class ZoneGain(Effect):
    """All laser light that a zone receives is counted with one factor, whatever way it came."""

    id = "zone_gain"
    acts_on = "optics"
    order = 1  # Sensitivity concerns stray light and crosstalk too: they come before.
    sentence = "A zone counts its laser light with a factor of its own, the same at all ranges and times."
    look_alikes = (
        LookAlike(
            "reflectance_map",
            "Turn the sensor about its axis: a gain stays with the zone, reflectance with the surface.",
        ),
        LookAlike(
            "stray_light", "Cover half of the target: a gain still multiplies, stray light adds what others see."
        ),
        LookAlike("gain_drift", "Repeat the first capture at the end: a gain is as it was, a drift is not."),
    )
    parameters = (
        Parameter(
            "factor",
            unit="1",
            low=0.0,
            high=10.0,
            start=1.1,
            vanishes_at=1.0,
            axis="zone",
            sentence="Counts of the zone over those that its response map gives.",
        ),
    )

    def arrivals(self, values: Values, rendering: Rendering) -> Arrivals:
        """Each zone's light, multiplied."""
        factor = np.atleast_1d(values["factor"])[:, None]
        return replace(rendering.arrivals, light=rendering.arrivals.light * factor)


effect = ZoneGain()

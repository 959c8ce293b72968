"""`range_falloff`: signal does not fall with the square of range."""

from dataclasses import replace

import numpy as np
from scipy.constants import speed_of_light

from physics.arrivals import Arrivals
from physics.effect import Effect, LookAlike, Parameter, Values
from physics.rendering import Rendering


class RangeFalloff(Effect):
    """At range r the signal is the nominal model's over 1 + (overlap_range / r)².

    Out of focus, a spot's area grows as 1/r², and a detector of fixed area catches its part of it.
    """

    id = "range_falloff"
    acts_on = "scene"
    order = -1  # It concerns what surfaces send back, not what is added on the way.
    sentence = "Close to the sensor part of the light misses the detector: signal does not fall as 1/r²."
    look_alikes = (
        LookAlike("scattering_medium", "Clear the air: extinction goes, the optics' falloff stays."),
        LookAlike("pile_up", "Dim the target, not its range: pile-up lessens, falloff stays."),
        LookAlike("reflectance_map", "Step one target in range: only falloff changes with it."),
    )
    parameters = (
        Parameter(
            "overlap_range",
            unit="m",
            low=0.0,
            high=1.0,
            start=0.02,
            vanishes_at=0.0,
            by_zone=True,
            sentence="Range at which half of the light is caught; centimetres for such optics.",
        ),
    )

    def arrivals(self, values: Values, rendering: Rendering) -> Arrivals:
        """Light by its time of arrival, which tells its range."""
        arrivals, lattice = rendering.arrivals, rendering.arrivals.lattice
        zero = np.broadcast_to(rendering.clock.time_zero_s, arrivals.light.shape[:2])[..., None]
        knots_s = lattice.first_s + lattice.step_s * np.arange(lattice.size)
        # Nothing is nearer than a knot: what arrives earlier is rounding, and must not divide by 0.
        ranges = speed_of_light / 2 * np.maximum(knots_s - zero, lattice.step_s)
        overlap = np.atleast_1d(values["overlap_range"])[:, None] / ranges
        return replace(arrivals, light=arrivals.light / (1 + overlap**2))


effect = RangeFalloff()

"""`second_surface`: glass or a half-transparent sheet."""

from dataclasses import replace

import numpy as np
from scipy.constants import speed_of_light

from physics.arrivals import Arrivals
from physics.effect import Effect, LookAlike, Parameter, Values
from physics.rendering import Rendering


class SecondSurface(Effect):
    """Part of the light passes the surface and returns from an equal one behind it: a second pulse, dimmer by 1/r²."""

    id = "second_surface"
    acts_on = "scene"
    sentence = "Light passes a half-transparent surface and returns from a second one at a fixed distance behind it."
    look_alikes = (
        LookAlike("multipath", "Step the target in range: the distance of the two pulses stays, a bounce's changes."),
        LookAlike("impulse_tail", "Put an opaque target in its place: a tail stays, the second surface goes."),
        LookAlike("afterpulsing", "Put an opaque target in its place: an afterpulse stays, the second surface goes."),
    )
    parameters = (
        Parameter(
            "passed",
            unit="1",
            low=0.0,
            high=1.0,
            start=0.1,
            vanishes_at=0.0,
            sentence="Part of the light that the first surface lets pass, out and back together.",
        ),
        Parameter(
            "spacing",
            unit="m",
            low=0.0,
            high=5.0,
            start=0.05,
            sentence="Optical distance between the two surfaces; centimetres for a double pane.",
        ),
    )

    def arrivals(self, values: Values, rendering: Rendering) -> Arrivals:
        """Each zone's light in part once more, later and spread over a larger sphere."""
        first, passed, spacing = rendering.arrivals, values["passed"], values["spacing"]
        lattice = first.lattice
        zero = np.broadcast_to(rendering.clock.time_zero_s, first.light.shape[:2])[..., None]
        knots_s = lattice.first_s + lattice.step_s * np.arange(lattice.size)
        ranges = speed_of_light / 2 * np.maximum(knots_s - zero, lattice.step_s)
        spread = replace(first, light=first.light * (ranges / (ranges + spacing)) ** 2)
        second = spread.delayed(2 * spacing / speed_of_light)
        return replace(first, light=(1 - passed) * first.light + passed * second.light)


effect = SecondSurface()

"""`second_surface`: glass or a half-transparent sheet."""

from dataclasses import replace

import numpy as np
from scipy.constants import speed_of_light

from physics.arrivals import Arrivals
from physics.effect import Effect, LookAlike, Parameter, Values
from physics.rendering import Rendering

# A sheet in front nearer to the sensor than this, or than half the range of what is behind it, fades as it comes
# nearer: it would soon be all that is seen. Range, metres.
NEAREST_M = 0.1


class SecondSurface(Effect):
    """Part of the light returns from an equal surface `spacing` behind the first, or before it where negative.

    Behind it is what the first surface lets pass, before it a sheet that sends part back before the light gets there.
    Either way the second pulse has `passed` of the light of the first, by the square of the ratio of their ranges, and
    the first is dimmer by as much. A sheet at or behind the sensor is dark.
    """

    id = "second_surface"
    acts_on = "scene"
    sentence = "Part of the light returns from a second surface, a fixed distance behind the first or before it."
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
            sentence="Part of the light that returns from the second surface in place of the first.",
        ),
        Parameter(
            "spacing",
            unit="m",
            low=-5.0,
            high=5.0,
            start=0.05,
            tries=(-0.2, 0.05, 0.15, 0.4),
            sentence="Optical distance to the second surface, negative before the first; that of panes is centimetres.",
        ),
    )

    def arrivals(self, values: Values, rendering: Rendering) -> Arrivals:
        """Each zone's light in part once more, later and spread over a larger sphere, or earlier over a smaller one."""
        first, passed, spacing = rendering.arrivals, values["passed"], values["spacing"]
        lattice = first.lattice
        zero = np.broadcast_to(rendering.clock.time_zero_s, first.light.shape[:2])[..., None]
        knots_s = lattice.first_s + lattice.step_s * np.arange(lattice.size)
        ranges = speed_of_light / 2 * np.maximum(knots_s - zero, lattice.step_s)
        spread = replace(first, light=first.light * _spread(ranges, spacing))
        second = spread.delayed(2 * spacing / speed_of_light)
        return replace(first, light=(1 - passed) * first.light + passed * second.light)


def _spread(range_m: np.ndarray, spacing_m: float) -> np.ndarray:
    """How many times as much light returns from a surface so much farther, or nearer where negative."""
    there = range_m + spacing_m
    if spacing_m >= 0:
        return (range_m / there) ** 2
    nearest = np.minimum(NEAREST_M, range_m / 2)
    return (range_m / np.maximum(there, nearest)) ** 2 * np.clip(there / nearest, 0, 1)


effect = SecondSurface()

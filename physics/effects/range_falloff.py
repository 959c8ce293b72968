"""`range_falloff`: signal does not fall with the square of range."""

from dataclasses import replace

import numpy as np
from scipy.constants import speed_of_light

from physics.arrivals import Arrivals
from physics.effect import Effect, LookAlike, Parameter, Values
from physics.rendering import Rendering

# Largest range that light may be lost up to, metres; part of all pixels that is near.
FARTHEST, NEAR = 5.0, 0.05
# By how much exponents of zones behind one lens may differ; where ranges hardly vary any factors are powers of them.
UNEVEN = 0.5


class RangeFalloff(Effect):
    """At range r the signal is the nominal model's over (1 + (overlap_range / r)^steepness)·(r / 1 m)^exponent.

    Out of focus, a spot's area grows as 1/r², and a detector of fixed area catches its part of it: steepness 2. In
    focus at another range than infinity, of which `focus` is the inverse, it grows with (1/r - focus)² instead. Fields
    of emitter and receiver that lie beside each other meet more suddenly; of Gaussian beams a part
    1 - exp(-(r / overlap_range)^steepness) is caught, and of a beam that moves evenly into a field of its own width
    (r / overlap_range)^steepness until that is 1. `sudden` is how far from one law to the next. Where these look past
    each other, or a lens is focused at some distance, the law is a power of another exponent over the ranges that are
    met.
    """

    id = "range_falloff"
    acts_on = "scene"
    order = -1  # It concerns what surfaces send back, not what is added on the way.
    sentence = (
        "Signal does not fall with the square of range: close to the sensor part of the light misses the detector."
    )
    look_alikes = (
        LookAlike("scattering_medium", "Clear the air: extinction goes, the optics' falloff stays."),
        LookAlike("pile_up", "Dim the target, not its range: pile-up lessens, falloff stays."),
        LookAlike("reflectance_map", "Step one target in range: only falloff changes with it."),
    )
    forms = (
        ("overlap_range",),
        ("overlap_range", "steepness"),
        ("overlap_range", "sudden"),
        ("exponent",),
        ("overlap_range", "focus"),
        ("overlap_range", "steepness", "sudden"),
    )
    richer = forms[-1:]
    parameters = (
        Parameter(
            "overlap_range",
            unit="m",
            low=0.0,
            high=FARTHEST,
            start=0.02,
            vanishes_at=0.0,
            axis="zone",
            power=2.0,
            sentence="Range at which half of the light is caught; centimetres for such optics.",
        ),
        Parameter(
            "steepness",
            unit="1",
            low=1.0,
            high=8.0,
            start=2.0,
            tries=(4.0,),
            sentence="Power of range with which light is lost, far closer than that.",
        ),
        Parameter(
            "focus",
            unit="1/m",
            low=0.0,
            high=20.0,
            start=0.0,
            sentence="Inverse of the range at which the optics are in focus.",
        ),
        Parameter("sudden", "1", 0.0, 2.0, 0.0, "0 where overlap sets in by a ratio, 1 exponentially, 2 evenly."),
        Parameter(
            "exponent",
            unit="1",
            low=-3.0,
            high=3.0,
            start=0.2,
            vanishes_at=0.0,
            axis="zone",
            sentence="By how much faster than with the square of range the signal falls.",
        ),
    )

    def arrivals(self, values: Values, rendering: Rendering) -> Arrivals:
        """Light by its time of arrival, which tells its range."""
        arrivals, lattice = rendering.arrivals, rendering.arrivals.lattice
        zero = np.atleast_2d(rendering.clock.time_zero_s)[..., None]
        knots_s = lattice.first_s + lattice.step_s * np.arange(lattice.size)
        # Nothing is nearer than a knot: what arrives earlier is rounding, and must not divide by 0.
        ranges = speed_of_light / 2 * np.maximum(knots_s - zero, lattice.step_s)
        blurred = np.abs(1 / ranges - values["focus"])
        lost = (np.atleast_1d(values["overlap_range"])[:, None] * blurred) ** values["steepness"]
        faster = np.atleast_1d(values["exponent"])[:, None]
        # Alike in all frames, unless their clock moves.
        caught = 1 / (1 + lost)
        if values["sudden"]:
            ratio = 1 / np.maximum(lost, 1e-300)
            laws = caught, -np.expm1(-ratio), np.minimum(ratio, 1)
            first = min(int(values["sudden"]), 1)
            caught = laws[first] + (values["sudden"] - first) * (laws[first + 1] - laws[first])
        part = ranges**-faster * caught
        return replace(arrivals, light=arrivals.light * part)

    def strained(self, values: Values, rendering: Rendering) -> bool:
        """Zones whose light falls by powers that are nothing like one another's have factors of their own."""
        return bool(np.ptp(values["exponent"]) > UNEVEN)

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """An exponential that loses some, or much, of what is near, as it has no slope where it loses nothing; and foci
        at what is near, amid and far.
        """
        ranges = rendering.light.range_m[rendering.light.range_m > 0]
        if not len(ranges):
            return []
        near, amid, far = (float(of) for of in np.quantile(ranges, (NEAR, 0.5, 1 - NEAR)))
        sudden = [{"overlap_range": part * near, "sudden": 1.0} for part in (0.6, 1.0) if part * near < FARTHEST]
        # As much out of focus at one end as loses a tenth there, with the other in focus.
        blurred = min(float(np.sqrt(0.1) / max(1 / near - 1 / far, 1e-3)), FARTHEST)
        highest = self.parameter("focus").high
        return sudden + [{"overlap_range": blurred, "focus": min(1 / at, highest)} for at in (near, amid, far)]


effect = RangeFalloff()

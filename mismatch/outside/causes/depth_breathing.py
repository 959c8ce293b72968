"""The depth camera's scale changes as time goes by."""

from functools import partial

import numpy as np

from mismatch.outside.farther import farther
from physics.arrivals import arrivals
from physics.effect import Effect, Parameter, Values
from physics.light import Light
from physics.pace import frame_interval_s
from physics.rendering import Rendering

# By so much ranges are changed to see what counts do.
SLIGHTLY = 1e-3
# Rates up to half of that of the frames are looked at; those below one period in the recording are a drift.
RATES = 200


class DepthBreathing(Effect):
    """Surfaces are at r · (1 + `rising` t + `sine` sin φ + `cosine` cos φ) where the camera says r, φ = 2π `rate` t.

    t is the time of the frame. The baseline of two cameras grows with their temperature, and a regulator that heats or
    cools them hunts. Nearer surfaces are brighter by the inverse square; a clock that drifts moves all ranges by as
    much, and leaves counts as they are.
    """

    id = "depth_breathing"
    acts_on = "scene"
    sentence = "ranges differ from the camera's by a factor that changes with time"
    forms = (("rising",), ("sine", "cosine", "rate"))
    parameters = (
        Parameter("rising", "1/s", -0.5, 0.5, 0.002, "Relative, in a second.", vanishes_at=0.0),
        Parameter("sine", "1", -0.2, 0.2, 0.005, "Relative, at a quarter of a period.", vanishes_at=0.0),
        Parameter("cosine", "1", -0.2, 0.2, 0.005, "Relative, at none.", vanishes_at=0.0),
        Parameter("rate", "1/s", 1e-4, 1e3, 1.0, "Periods in a second."),
    )

    def light(self, values: Values, rendering: Rendering) -> Light:
        """The scene at its true ranges."""
        light = rendering.light
        time_s = np.asarray(light.time_s, float)
        phase = 2 * np.pi * values["rate"] * time_s
        by = values["rising"] * time_s + values["sine"] * np.sin(phase) + values["cosine"] * np.cos(phase)
        return farther(light, lambda _: 1 + by[:, None, None])

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """The rate at which a scale that goes to and fro explains most of an excess, to first order."""
        time_s = np.asarray(rendering.light.time_s, float)
        step_s = frame_interval_s(time_s)
        if not step_s > 0:
            return []
        more, less = (
            arrivals(
                farther(rendering.light, partial(np.full_like, fill_value=one)), rendering.footprints, rendering.clock
            ).binned()
            for one in (1 + SLIGHTLY, 1 - SLIGHTLY)
        )
        slope = rendering.gain * (more - less) / (2 * SLIGHTLY)
        found, told = ((slope * of / np.maximum(expected, 1)).sum(axis=(1, 2)) for of in (excess, slope))
        rates = np.linspace(1 / max(float(np.ptp(time_s)), step_s), 0.5 / step_s, RATES)
        waves = np.exp(2j * np.pi * rates[:, None] * time_s)
        # Of sine and cosine alike: two numbers, told as well as each other in the mean.
        gained = np.abs(waves @ (found - told * found.sum() / max(told.sum(), 1e-300)))
        rate = self.parameter("rate")
        return [{"rate": float(np.clip(rates[gained.argmax()], rate.low, rate.high))}]


effect = DepthBreathing()

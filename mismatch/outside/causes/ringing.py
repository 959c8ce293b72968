"""The laser's driver rings: pulses are followed by an oscillation that dies away."""

from dataclasses import replace

import numpy as np
from scipy.signal import fftconvolve

from physics.clock import Clock
from physics.effect import Effect, Parameter, Values
from physics.pulse import ImpulseResponse
from physics.rendering import Rendering

# Time constants over which the oscillation is followed.
LASTS = 8


class Ringing(Effect):
    """The pulse is followed by exp(-t/tau) · sin(2πt/period), above and below, `share` of it by absolute values.

    A circuit of second order, as laser, leads and capacitor are, answers so to a step of current. There is no less than
    no light.
    """

    id = "ringing"
    acts_on = "time"
    order = 2  # Whatever the pulse has become.
    sentence = "each pulse is followed by an oscillation that dies away"
    forms = (("share", "tau", "period"),)
    parameters = (
        Parameter("share", "1", 0.0, 3.0, 0.05, "Of the oscillation, over the pulse.", vanishes_at=0.0),
        Parameter("tau", "s", 1e-10, 1e-8, 1e-9, "In which it dies away."),
        Parameter("period", "s", 2e-10, 1e-8, 1e-9, "From one crest to the next.", tries=(5e-10, 1e-9, 2e-9)),
    )

    def clock(self, values: Values, rendering: Rendering) -> Clock:
        """The same clock with a pulse that rings."""
        pulse = rendering.clock.pulse
        if not values["share"]:
            return rendering.clock
        t = pulse.step_s * np.arange(int(LASTS * values["tau"] / pulse.step_s) + 2)
        wave = np.exp(-t / values["tau"]) * np.sin(2 * np.pi * t / values["period"])
        after = fftconvolve(pulse.probability, wave / max(float(np.abs(wave).sum()), 1e-30))
        rings = values["share"] * after
        rings[: len(pulse.probability)] += pulse.probability
        rings = np.maximum(rings, 0)
        time_s = pulse.time_s[0] + pulse.step_s * np.arange(len(rings))
        whole = float(pulse.probability.sum()) / max(float(rings.sum()), 1e-30)
        return replace(rendering.clock, pulse=ImpulseResponse(time_s, rings * whole))


effect = Ringing()

"""`afterpulsing`: an avalanche traps carriers, which release a later one."""

import numpy as np
from scipy.signal import lfilter

from physics.effect import Effect, LookAlike, Parameter, Values
from physics.rendering import Rendering

# Traps hold carriers for nanoseconds and more; what comes sooner, without a hold-off, is rather the pulse's own tail.
SOONEST_S = 1.5e-9


class Afterpulsing(Effect):
    """Each event is followed by another with some probability, an exponentially distributed time later.

    Delays run from the end of the event's bin and a hold-off of `dead` after it, until when the detector is taken to
    count nothing: with dead 0, j bins later come (1 - q)·q^(j-1) of the afterpulses, q = exp(-bin width / τ); those
    beyond the last bin are lost. Afterpulses of afterpulses are left out: they go with the probability squared.
    """

    id = "afterpulsing"
    acts_on = "detector"
    order = 2  # Only what was registered is followed by afterpulses, so pile-up comes before.
    sentence = "Part of the detected photons sets off a second count later, in an exponentially falling echo."
    look_alikes = (
        LookAlike(
            "impulse_tail", "Look many bins after the pulse: a tail is over in a nanosecond or so, the echo goes on."
        ),
        LookAlike("ambient_pedestal", "Cover the emitter: a pedestal stays, afterpulses of the laser's light go."),
        LookAlike("multipath", "Take the target out of the corner: the echo stays, a second bounce goes."),
    )
    forms = (("probability", "tau"), ("probability", "tau", "dead"))
    parameters = (
        Parameter(
            "probability",
            unit="1",
            low=0.0,
            high=1.0,
            start=0.01,
            vanishes_at=0.0,
            sentence="Afterpulses for each event.",
        ),
        Parameter(
            "tau",
            unit="s",
            low=2e-10,
            high=1e-6,
            start=5e-9,
            tries=(5e-10, 2e-9, 5e-9, 2e-8),
            sentence="Mean delay of an afterpulse, after the hold-off.",
        ),
        Parameter(
            "dead",
            unit="s",
            low=0.0,
            high=2e-8,
            start=0.0,
            tries=(5e-10, 3e-9),
            sentence="How long after an event's bin none is released or counted.",
        ),
    )

    def strained(self, values: Values, rendering: Rendering) -> bool:
        """An echo at once that is over in a nanosecond is a tail of the pulse."""
        return values["probability"] > 0 and values["tau"] < SOONEST_S and values["dead"] < rendering.clock.bin_width_s

    def expected(self, values: Values, rendering: Rendering) -> np.ndarray:
        """Counts and their echo."""
        width = rendering.clock.bin_width_s
        kept = np.exp(-width / values["tau"])
        whole, part = divmod(values["dead"] / width, 1)
        # Of the first bin after the hold-off only the rest is left: `waits` of the afterpulses come in later ones.
        waits = np.exp(-(1 - part) * width / values["tau"])
        response = [*np.zeros(min(int(whole), rendering.expected.shape[-1])), 0.0, 1 - waits, waits - kept]
        echo = lfilter(response, [1.0, -kept], rendering.expected, axis=-1)
        return rendering.expected + values["probability"] * echo


effect = Afterpulsing()

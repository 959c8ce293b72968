"""`impulse_tail`: carriers that diffuse before they avalanche, and a laser that turns off slowly."""

from dataclasses import replace

from physics.clock import Clock
from physics.effect import Effect, LookAlike, Parameter, Values
from physics.rendering import Rendering


class ImpulseTail(Effect):
    """A share of the photons is registered late by an exponentially distributed delay."""

    id = "impulse_tail"
    acts_on = "time"
    sentence = "Part of every pulse is registered late, with an exponentially falling delay, whatever its brightness."
    look_alikes = (
        LookAlike(
            "afterpulsing", "Tails end within nanoseconds; step the target in range and look many bins after the pulse."
        ),
        LookAlike("multipath", "Take the target out of the corner: a tail stays, a second bounce goes."),
        LookAlike("impulse_width", "Look at the early flank: a wider pulse rises earlier, a tail leaves it as it is."),
    )
    parameters = (
        Parameter(
            "share",
            unit="1",
            low=0.0,
            high=1.0,
            start=0.1,
            vanishes_at=0.0,
            sentence="Part of the photons that is delayed.",
        ),
        Parameter(
            "tau",
            unit="s",
            low=1e-12,
            high=3e-9,
            start=3e-10,
            tries=(1e-10, 3e-10, 1e-9),
            sentence="Mean delay.",
        ),
    )

    def clock(self, values: Values, rendering: Rendering) -> Clock:
        """The pulse, exponentially modified in part."""
        pulse = rendering.clock.pulse.with_tail(values["tau"], values["share"])
        return replace(rendering.clock, pulse=pulse)


effect = ImpulseTail()

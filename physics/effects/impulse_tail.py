"""`impulse_tail`: carriers that diffuse before they avalanche, and a laser that turns off slowly."""

from dataclasses import replace
from typing import Any

import numpy as np

from physics.arrivals import Arrivals
from physics.clock import Clock
from physics.effect import Effect, LookAlike, Parameter, Values
from physics.rendering import Rendering
from physics.waits import half_life, late

# Carriers have diffused, and lasers turned off, within this; what falls more slowly is rather released by traps.
SLOWEST_S = 2e-9
# A tail that is over within this part of a bin is none that anybody would see.
FASTEST_BINS = 0.2


class ImpulseTail(Effect):
    """Photons are registered late: by an exponentially distributed delay, as carriers diffuse, or evenly up to an end.

    The latter is a laser that lingers at a low level and then stops. Carriers that come from many depths fall less
    steeply in the end, and a laser that turns off along a ramp more steeply: `heavy`, of `waits.waiting`. This tail is
    the detector's, which may delay another share of the photons in each zone: then light is delayed by knots of the
    lattice, step for step as the pulse is where all zones have the same. A laser's tail may come in addition to a pulse
    that is as it was, by the part `added`.
    """

    id = "impulse_tail"
    acts_on = "time"
    grows = True
    sentence = (
        "Part of every pulse is registered late, by a few tenths of a nanosecond or more, whatever its brightness."
    )
    look_alikes = (
        LookAlike(
            "afterpulsing", "Tails end within nanoseconds; step the target in range and look many bins after the pulse."
        ),
        LookAlike("multipath", "Take the target out of the corner: a tail stays, a second bounce goes."),
        LookAlike("impulse_width", "Look at the early flank: a wider pulse rises earlier, a tail leaves it as it is."),
    )
    forms = (("share", "tau"), ("lingering", "duration"), ("share", "tau", "heavy"))
    parameters = (
        Parameter(
            "share",
            unit="1",
            low=0.0,
            high=1.0,
            start=0.1,
            vanishes_at=0.0,
            axis="zone",
            sentence="Part of the photons that is delayed.",
        ),
        Parameter(
            "tau",
            unit="s",
            low=1e-12,
            high=SLOWEST_S,
            start=3e-10,
            tries=(1e-10, 3e-10, 1e-9),
            sentence="Mean delay.",
        ),
        Parameter(
            "lingering",
            unit="1",
            low=0.0,
            high=1.0,
            start=0.1,
            vanishes_at=0.0,
            sentence="Part of the photons that a laser sends which lingers.",
        ),
        Parameter(
            "duration",
            unit="s",
            low=1e-11,
            high=6e-9,
            start=1e-9,
            tries=(5e-10, 1e-9, 2e-9, 4e-9),
            sentence="Time after which it stops.",
        ),
        Parameter(
            "heavy",
            unit="1",
            low=-0.5,
            high=2.0,
            start=0.0,
            tries=(-0.4, 0.6),
            sentence="Falls with the power 1 + 1/heavy of time; 0 exponentially, -1/2 on a straight line until 2 tau.",
        ),
        Parameter("added", "1", 0.0, 1.0, 0.0, "Part of `share` that comes in addition to the pulse, not out of it."),
    )

    def strained(self, values: Values, rendering: Rendering) -> bool:
        """Where half of the photons wait as long as those that traps hold, it is an echo rather than a tail.

        Where they wait a small part of a bin it is a delay, or a gain where it is added.
        """
        if not np.any(values["share"]):
            return False
        half = half_life(values["tau"], values["heavy"]) / np.log(2)
        return half > SLOWEST_S or half < FASTEST_BINS * rendering.clock.bin_width_s

    def clock(self, values: Values, rendering: Rendering) -> Clock:
        """The pulse, delayed in part."""
        pulse = rendering.clock.pulse
        if values["lingering"]:
            pulse = pulse.with_tail(values["duration"], values["lingering"], heavy=-1.0)
        if not _by_zone(values) and values["share"]:
            pulse = pulse.with_tail(values["tau"], values["share"], values["heavy"])
        return replace(rendering.clock, pulse=pulse)

    def arrivals(self, values: Values, rendering: Rendering) -> Arrivals:
        """Light, delayed in part where zones differ in how much."""
        if not _by_zone(values):
            return rendering.arrivals
        share = np.atleast_1d(values["share"])[:, None]
        here = rendering.arrivals
        delayed = late(here.light, here.lattice.step_s, values["tau"], values["heavy"])
        return replace(here, light=here.light + share * (delayed - (1 - values["added"]) * here.light))

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, Any]]:
        """One that is added: where zones differ in it, as else that is a matter of the gain."""
        each = np.full(expected.shape[1], self.parameter("share").start)
        return [{"share": each, "tau": tau, "added": 1.0} for tau in self.parameter("tau").tries]


def _by_zone(values: Values) -> bool:
    """Whether light is delayed and not the pulse."""
    return np.ndim(values["share"]) > 0 or (values["added"] > 0 and values["share"] > 0)


effect = ImpulseTail()

"""`range_walk`: the brighter a pulse, the earlier it is registered."""

from dataclasses import replace

import numpy as np

from physics.arrivals import Arrivals, arrivals
from physics.effect import Effect, LookAlike, Parameter, Values
from physics.rendering import Rendering

# A delay that differs by less than this part of itself over all that is seen does not go with the light.
VARYING = 0.25


class RangeWalk(Effect):
    """A zone that receives S counts of signal in a frame registers them earlier by walk · S / (S + level), or by
    logarithmic · ln(1 + S / level), less what this is at `reference` counts: those of the targets that time zero was
    measured with.

    A bright pulse crosses the comparator's threshold sooner on its rising flank, by no more than that flank is long;
    where the flank is exponential the threshold is crossed sooner by the logarithm of how bright it is, without end.
    S is the sum over the whole window, or, by the part `fullest`, what the fullest bin holds, as a comparator sees how
    high a pulse is and not how long light goes on: two pulses in one histogram walk together. Light from beyond the
    window, which the walk would bring into its last bins, is not followed.
    """

    id = "range_walk"
    acts_on = "time"
    grows = True
    order = 1  # It goes by all light that arrives.
    sentence = "Light is registered earlier where there is more of it."
    look_alikes = (
        LookAlike(
            "pile_up", "Halve the laser power: range walk moves the pulse whole, pile-up also restores its late side."
        ),
        LookAlike("time_zero_offset", "Swap a white target for a black one: an offset stays, range walk changes."),
        LookAlike(
            "bin_width_error", "Step the range with white and black targets: the clock's error is the same for both."
        ),
    )
    forms = (
        ("walk", "level"),
        ("logarithmic", "level"),
        ("walk", "level", "reference"),
        ("logarithmic", "level", "reference"),
    )
    parameters = (
        # As large as the delays between zones of such sensors: about 50 ps.
        Parameter(
            "walk",
            unit="s",
            low=0.0,
            high=2e-9,
            start=5e-11,
            vanishes_at=0.0,
            axis="zone",
            sentence="How much earlier the brightest light is registered than the faintest.",
        ),
        Parameter(
            "logarithmic",
            unit="s",
            low=0.0,
            high=2e-9,
            start=2e-11,
            vanishes_at=0.0,
            axis="zone",
            sentence="How much earlier light is registered that is brighter by a factor of e, far above the level.",
        ),
        Parameter(
            "level",
            unit="counts",
            low=1.0,
            high=1e9,
            start=1e4,
            tries=(1e3, 1e4, 1e5),
            sentence="Counts of signal in a zone and frame at which half of the walk, or a logarithm of 2, is reached.",
        ),
        Parameter(
            "reference",
            unit="counts",
            low=1e-9,
            high=1e9,
            start=1e-9,
            tries=(1e4,),
            sentence="Counts of signal in a zone and frame that are registered when they should be.",
        ),
        Parameter("fullest", "1", 0.0, 1.0, 0.0, "Whether it goes by the fullest bin (1) or by the sum of all (0)."),
    )

    def moves_light(self, values: Values) -> bool:
        """See `Effect`."""
        return bool(np.any(values["walk"]) or np.any(values["logarithmic"]))

    def arrivals(self, values: Values, rendering: Rendering) -> Arrivals:
        """Light of each zone and frame, earlier by its own sum."""
        return rendering.arrivals.delayed(-_early_s(values, rendering))

    def strained(self, values: Values, rendering: Rendering) -> bool:
        """Where all light is far above the level a walk is an offset, of each zone where each has its own."""
        seen = rendering.arrivals or arrivals(rendering.light, rendering.footprints, rendering.clock)
        early_s = _early_s(values, replace(rendering, arrivals=seen))
        own = np.ndim(values["walk"]) or np.ndim(values["logarithmic"])
        varies = np.ptp(early_s, axis=0 if own else None)
        return bool(np.max(varies) < VARYING * np.abs(early_s).max())

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """Time zero measured with the faintest, the usual and the brightest of what was recorded."""
        light = np.maximum(expected - rendering.background, 0)
        level, reference = self.parameter("level"), self.parameter("reference")
        found = []
        for fullest, signal in ((0.0, light.sum(axis=-1)), (1.0, light.max(axis=-1))):
            counts = np.clip(np.quantile(signal, (0.02, 0.5, 0.98)), reference.low, reference.high)
            usual = float(np.clip(counts[1], level.low, level.high))
            ways = [{"reference": float(one), "level": at} for one in counts for at in (usual, level.low)]
            # What is as it starts is not said, so that it is no number of the form's.
            found += ways if fullest == 0 else [way | {"fullest": fullest} for way in ways]
        return found


def _early_s(values: Values, rendering: Rendering) -> np.ndarray:
    """(F, P) seconds by which each zone registers a frame's light early."""
    signal = rendering.gain * _measured(rendering, values["fullest"])
    level, reference = values["level"], values["reference"]
    bounded = signal / (signal + level) - reference / (reference + level)
    endless = np.log1p(signal / level) - np.log1p(reference / level)
    return np.atleast_1d(values["walk"]) * bounded + np.atleast_1d(values["logarithmic"]) * endless


def _measured(rendering: Rendering, fullest: float) -> np.ndarray:
    """(F, P) light that the walk goes by."""
    total = rendering.arrivals.light.sum(axis=-1)
    return total + fullest * (rendering.arrivals.binned().max(axis=-1) - total) if fullest else total


effect = RangeWalk()

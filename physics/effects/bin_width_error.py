"""`bin_width_error`: the clock that makes the bins runs slow or fast."""

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.constants import speed_of_light

from physics.arrivals import Arrivals
from physics.clock import MOST_STEPS_PER_BIN, Clock
from physics.effect import Effect, LookAlike, Parameter, Values
from physics.pulse import ImpulseResponse
from physics.rendering import Rendering

LARGEST = 0.1
# What any one bin's share of a pulse may be off by; five times as near costs five times the knots, in every fit.
TOLERANCE = 5e-4


class BinWidthError(Effect):
    """Bins are bin_width · (1 + error) wide: what truly takes t is registered after t / (bin_width · (1 + error)) bins.

    A clock that warms up settles: after s seconds of the session bins are bin_width · (1 + error + warmup ·
    (1 - exp(-s/τ))) wide. Zones of several converters each may have a further part, `apart`. Of what these two change
    the width of the pulse is left out, second to its place.

    Where time zero was measured in bins, by the same clock, a target at range 0 stays in its bin, and all others come
    nearer by the factor 1 / (1 + error); where it is known in seconds, that target comes nearer, too. The laser's pulse
    lasts as many seconds as before, hence fewer bins by the same factor; or as many bins, where its response was
    measured in bins by the same clock (`pulse_in_bins`). Background is counts per bin as this clock
    recorded them: unchanged. Where time zero was told by the recording itself, it is what fits the ranges that were
    seen: then a target at `still_at` stays where it is, and nearer ones come nearer still.
    """

    id = "bin_width_error"
    acts_on = "time"
    order = -2  # What other effects on time say is in true seconds.
    sentence = "The sensor's clock is slow or fast, so that all its bins are wider or narrower than assumed."
    look_alikes = (
        LookAlike("time_zero_offset", "Step the target in range: an offset stays, an error of the clock grows."),
        LookAlike("range_walk", "Step the range with white and black targets: the clock's error is the same for both."),
        LookAlike(
            "bin_nonlinearity", "Look at a flat pedestal: unequal bins print their pattern on it, a clock does not."
        ),
        LookAlike("impulse_width", "Step the target in range: a wider pulse stays where it is."),
    )
    forms = (
        ("error",),
        ("error", "zero_in_seconds"),
        ("error", "pulse_in_bins"),
        ("warmup", "tau"),
        ("error", "warmup", "tau"),
        ("warmup", "tau", "zero_in_seconds"),
        ("apart",),
        ("error", "apart"),
        ("error", "still_at"),
    )
    richer, uneven, untold = forms[-2:-1], (("apart",),), forms[-1:]
    parameters = (
        # Makers state 3 % for such sensors before correction.
        Parameter(
            "error",
            unit="1",
            low=-LARGEST,
            high=LARGEST,
            start=0.01,
            vanishes_at=0.0,
            sentence="By what part bins are wider than assumed, narrower where negative.",
        ),
        Parameter("warmup", "1", -0.05, 0.05, 0.01, "Part by which they become wider as it warms up.", vanishes_at=0.0),
        Parameter(
            "apart", "1", -0.05, 0.05, 0.01, "Part by which those of a zone are wider.", vanishes_at=0.0, axis="zone"
        ),
        Parameter("tau", "s", 1e-2, 1e4, 1.0, "Time constant of the warming up.", tries=(0.5, 5.0)),
        Parameter(
            "zero_in_seconds",
            unit="1",
            low=0.0,
            high=1.0,
            start=0.0,
            tries=(1.0,),
            sentence="Part of time zero that is known in seconds: 0 where it was measured in bins.",
        ),
        Parameter(
            "pulse_in_bins", "1", 0.0, 1.0, 0.0, "Part of a pulse's length that was measured in bins.", tries=(1.0,)
        ),
        Parameter("still_at", "m", 0.0, 50.0, 0.0, "Range at which targets stay in their bins.", tries=(1.0,)),
    )

    def moves_light(self, values: Values) -> bool:
        """See `Effect`."""
        return bool(values["warmup"] or np.any(values["apart"]))

    def clock(self, values: Values, rendering: Rendering) -> Clock:
        """The clock with bins that wide."""
        clock, scale = rendering.clock, 1 + values["error"]
        if scale == 1:
            return clock
        zero = np.asarray(clock.time_zero_s) * (1 + values["error"] * (1 - values["zero_in_seconds"]))
        return replace(
            clock,
            bin_width_s=clock.bin_width_s * scale,
            time_zero_s=zero + values["error"] * _flight_s(values),
            pulse=_in_steps_of(clock.pulse, scale, clock.bin_width_s, 1 + values["error"] * values["pulse_in_bins"]),
        )

    def arrivals(self, values: Values, rendering: Rendering) -> Arrivals:
        """Light that arrives sooner in bins that have become wider: what the clock above does not say."""
        if not (values["warmup"] or np.any(values["apart"])):
            return rendering.arrivals
        scale, ticks = 1 + values["error"], 1 - values["zero_in_seconds"]
        warm = -values["warmup"] * np.expm1(-rendering.light.time_s / values["tau"])
        now = scale + np.atleast_1d(values["apart"]) + warm[:, None]
        zero = (np.asarray(rendering.clock.time_zero_s) - values["error"] * _flight_s(values)) / (
            1 + values["error"] * ticks
        )
        return rendering.arrivals.stretched(scale / now, scale * (zero * ticks + _flight_s(values)))

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, Any]]:
        """Targets as far as most light comes from stay: by their bins time zero was told.

        Nothing else is told, so that forms without `still_at` begin where they did.
        """
        seen = rendering.light.returns[0]
        lit = np.nan_to_num(seen.strength)
        ranges = float((lit * np.where(lit > 0, seen.range_m, 0)).sum() / max(lit.sum(), 1e-300))
        return [{"still_at": ranges}]


def _flight_s(values: Values) -> float:
    """To the target that stays, and back."""
    return 2 * float(values["still_at"]) / speed_of_light


def _in_steps_of(pulse: ImpulseResponse, scale: float, bin_width_s: float, longer: float) -> ImpulseResponse:
    """A pulse `longer` times as long on steps `scale` times as wide, or an even part of that: bins of whole steps stay.

    Its cumulative, linear within a step, is read at the new edges. Between two of them it can be off by the kink there
    times a quarter of their distance; a bin has two ends. How many parts a step is cut into does not depend on the
    scale, so that counts are continuous in it.
    """
    kink = float(np.abs(np.diff(pulse.probability, prepend=0, append=0)).max())
    parts = int(np.ceil(2 * kink * (1 + LARGEST) / 4 / TOLERANCE))
    parts = max(1, min(parts, int(MOST_STEPS_PER_BIN * pulse.step_s / bin_width_s)))
    width = pulse.step_s * scale / parts
    length = pulse.edges[-1] - pulse.edges[0]
    edges = longer * pulse.edges[0] + width * np.arange(np.ceil(longer * length / width) + 1)
    return ImpulseResponse((edges[1:] + edges[:-1]) / 2, np.diff(pulse.cumulative(edges / longer)))


effect = BinWidthError()

"""`counter_saturation`: a counter that is full stops."""

import numpy as np
from scipy.special import gammainc, gammaincc

from physics.effect import Effect, LookAlike, Parameter, Values
from physics.rendering import Rendering

# Squares of standard deviations that a ceiling at its largest count must take off a zone's, for it to seem one.
SHOWN = 20.0
# Ceilings of two zones that are as far apart as this many standard deviations of counts are not one.
APART = 4.0


class CounterSaturation(Effect):
    """Of n counts the register shows the smaller of n and its ceiling C.

    For Poisson counts of mean λ the mean of what it shows is λ·Q(C - 1, λ) + C·P(C, λ), with the regularised
    incomplete gamma functions P and Q, since P(n < k) = Q(k, λ) (Abramowitz and Stegun 26.4.21).

    One that slows down before it is full shows f(n) = n / (1 + (slowing · n)^order)^(1/order), at most 1 / slowing. The
    mean of that is taken to second order of the counts' scatter about λ, f(λ) + λ f''(λ) / 2.
    """

    id = "counter_saturation"
    acts_on = "detector"
    order = 3  # The register is the last: whatever was detected is counted in it.
    sentence = "A bin's counter stops at its largest value and loses the counts beyond."
    forms = (("lost", "ceiling"), ("lost",), ("slowing", "order"))
    look_alikes = (
        LookAlike(
            "pile_up", "Look at the late flank of the pulse: pile-up starves it, a full counter leaves it alone."
        ),
        LookAlike("impulse_width", "Step away from the target: a wide pulse stays wide, a flat top goes."),
    )
    parameters = (
        Parameter(
            "lost",
            unit="1",
            low=0.0,
            high=1.0,
            start=1.0,
            vanishes_at=0.0,
            sentence="Part of the counts beyond the ceiling that is lost: 1 where the counter stops there.",
        ),
        Parameter(
            "ceiling",
            unit="counts",
            low=2.0,
            high=2.0**32,
            start=255.0,
            axis="zone",
            sentence="The largest count that a bin can show, 255 for 8 bits.",
        ),
        Parameter("slowing", "1/counts", 0.0, 0.5, 1e-3, "One over the count that it comes near to.", 0.0),
        # From 1 on it is what dead time does to a bin; the larger the more suddenly it stops.
        Parameter("order", "1", 1.5, 30.0, 4.0, "How suddenly it comes near to that.", tries=(2.0, 6.0)),
    )

    def expected(self, values: Values, rendering: Rendering) -> np.ndarray:
        """The mean of clipped Poisson counts."""
        mean, ceiling = _slowed(rendering.expected, values), np.asarray(values["ceiling"], float)
        shown = _shown(mean, ceiling[:, None] if ceiling.ndim else ceiling)
        # Not the mean less what is lost: of a mean of millions, rounding would be left on top of a low ceiling.
        return (1 - values["lost"]) * mean + values["lost"] * shown

    def strained(self, values: Values, rendering: Rendering) -> bool:
        """A counter that goes on to count most of what comes has not stopped."""
        return 0 < values["lost"] < 0.5

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """The largest count there is, and a little less; that of each zone which seems to stop there.

        Counters are alike where nothing tells otherwise: others stop where the one does that shows it most, unless they
        have counted beyond. Where ceilings are seen to differ nobody knows where the others are.
        """
        counts = expected + excess
        most = max(2.0, float(counts.max()))
        found = [{"ceiling": max(2.0, part * most)} for part in (0.8, 0.95, 1.0)]
        found += [{"slowing": 1 / (part * most)} for part in (1.05, 1.5)]
        largest = np.maximum(counts.max(axis=(0, 2)), 2.0)
        clipped = _shown(expected, largest[:, None])
        gained = ((counts - expected) ** 2 - (counts - clipped) ** 2) / np.maximum(expected, 1)
        gained = gained.sum(axis=(0, 2))
        stops, common = gained > SHOWN, largest[gained.argmax()]
        if stops.any():
            alike = np.ptp(largest[stops]) < APART * np.sqrt(common)
            others = np.where(alike & (largest <= common), common, self.parameter("ceiling").high)
            each = np.where(stops, largest, others)
            found.append({"lost": self.parameter("lost").start, "ceiling": each})
        return found


def _slowed(mean: np.ndarray, values: Values) -> np.ndarray:
    """Mean of Poisson counts that a counter shows which slows down."""
    if not values["slowing"]:
        return mean
    order = float(values["order"])
    full = (values["slowing"] * mean) ** order
    return np.maximum(mean * (1 + full) ** (-1 / order) - (order + 1) / 2 * full * (1 + full) ** (-1 / order - 2), 0)


def _shown(mean: np.ndarray, ceiling: np.ndarray | float) -> np.ndarray:
    """Mean of Poisson counts that are clipped."""
    return mean * gammaincc(ceiling - 1, mean) + ceiling * gammainc(ceiling, mean)


effect = CounterSaturation()

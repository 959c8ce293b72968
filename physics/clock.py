"""When arrivals are registered: bins, time zeros, pulse; and the lattice on which they are added up without error."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from physics.pulse import ImpulseResponse
from recordings.refusal import Refusal

# A response whose steps do not divide the bin is carried to steps that do: as many as keep its cumulative within this.
TOLERANCE = 1e-4
MOST_STEPS_PER_BIN = 512
# Steps and bins given in floating point count as commensurate within this share of a step over the whole response.
ROUNDING_STEPS = 1e-3
# What of a response lies in tails beyond this is lost in rounding.
NOTHING = 1e-15
EARLY_BINS = 2
# Knots to a bin where light is moved between them: a pulse becomes wider by 1/1000 of a squared bin at most.
MOVED_PER_BIN = 16
PARTS = 1 << 30


@dataclass(frozen=True, eq=False)
class Clock:
    """How P zones register time.

    bin_width_s: seconds. bins: T. time_zero_s: (P,), or (F, P) where it changes from frame to frame; arrival of a
    target at range 0, seconds from the start of bin 0. pulse: the impulse response. least_per_bin: fewest knots of the
    lattice to a bin, for effects that look at where within its bin light arrives.
    """

    bin_width_s: float
    bins: int
    time_zero_s: np.ndarray
    pulse: ImpulseResponse
    least_per_bin: int = 1

    @cached_property
    def lattice(self) -> "Lattice":
        """The lattice of this bin width and pulse."""
        # Light comes after time zero; what is delayed by less than nothing may come a little before.
        earliest = min(0.0, float(np.min(self.time_zero_s))) - EARLY_BINS * self.bin_width_s
        return Lattice.of(self.pulse, self.bin_width_s, self.bins, earliest, self.least_per_bin)

    def finer(self, per_bin: int = MOVED_PER_BIN) -> "Clock":
        """The same clock with so many knots of its lattice to a bin, or more."""
        return self if self.least_per_bin >= per_bin else replace(self, least_per_bin=per_bin)


@dataclass(frozen=True, eq=False)
class Lattice:
    """Times at which light may arrive, so that bins are linear in between.

    The share of a pulse that falls into a bin is, as a function of its nominal arrival, linear between knots: times at
    which an edge of one of the response's steps meets an edge of a bin. Where a bin holds a whole number of steps the
    knots lie a step apart, and light that arrives between two knots may be given to the two in proportion: no error.

    step_s: distance of the knots. per_bin: how many to a bin. cumulative: (N + 1,) of the response at the edges of its
    steps, from 0 to 1. first_s: nominal arrival of knot 0. size: how many knots light can arrive at and be seen.
    lead: by how many knots light of knot 0 comes after the latest that is registered before bin 0 entirely.
    error: bound on what any one bin's share of a pulse may be off by; rounding where a bin holds whole steps.
    """

    step_s: float
    per_bin: int
    cumulative: np.ndarray
    first_s: float
    size: int
    lead: int
    error: float

    @property
    def edges_s(self) -> np.ndarray:
        """(N + 1,) edges of the response's steps, seconds after its nominal arrival."""
        steps = len(self.cumulative) - 1
        return (self.lead - steps + np.arange(steps + 1)) * self.step_s - self.first_s

    @classmethod
    def of(
        cls, pulse: ImpulseResponse, bin_width_s: float, bins: int, earliest_s: float, least_per_bin: int = 1
    ) -> "Lattice":
        """The lattice for bins of this width, for light that arrives at `earliest_s` or later."""
        edges, cumulative = pulse.edges, pulse.edge_cumulative
        step = (edges[-1] - edges[0]) / (len(edges) - 1)
        per_bin = round(bin_width_s / step)
        # By how many steps the response is stretched over its length, taking the bin to hold a whole number of them.
        stretch = abs(bin_width_s / step / max(per_bin, 1) - 1) * len(edges)
        error = 2 * stretch * float(pulse.probability.max())
        if stretch > ROUNDING_STEPS:
            per_bin = 1 << int(np.ceil(np.log2(max(bin_width_s / step, 8))))
            while True:
                new = edges[0] + bin_width_s / per_bin * np.arange(
                    np.ceil((edges[-1] - edges[0]) / bin_width_s * per_bin) + 1
                )
                resampled = np.interp(new, edges, cumulative)
                # Both are linear between their knots and equal at the new ones, so they differ most at an old one.
                error = 2 * float(np.abs(np.interp(edges, new, resampled) - cumulative).max())
                if error <= TOLERANCE or per_bin >= MOST_STEPS_PER_BIN:
                    break
                per_bin *= 2
            edges, cumulative = new, resampled
        if per_bin < least_per_bin:
            # The cumulative is linear within a step: cut into equal parts it is the same response.
            parts = -(-least_per_bin // per_bin)
            places = np.arange(parts * (len(edges) - 1) + 1) / parts
            edges, cumulative = (np.interp(places, np.arange(len(edges)), values) for values in (edges, cumulative))
            per_bin *= parts
        start = int(np.searchsorted(cumulative, NOTHING, side="right")) - 1
        stop = int(np.searchsorted(cumulative, cumulative[-1] - NOTHING, side="left"))
        cumulative = cumulative[start : stop + 1]
        steps = len(cumulative) - 1
        if steps < 1:
            raise Refusal("irf has no probability above 0, expected a sum of 1")
        width = bin_width_s / per_bin
        # Light of this nominal arrival is registered before bin 0 entirely, later light is not.
        latest_unseen = -edges[start] - steps * width
        lead = max(0, int(np.floor((earliest_s - latest_unseen) / width)))
        size = max(2, bins * per_bin + steps + 1 - lead)
        # To so many parts of a step: knots that are the same but for rounding are the same.
        first = width * round((latest_unseen / width + lead) * PARTS) / PARTS
        return cls(width, per_bin, cumulative, first, size, lead, error)

"""An impulse response by a few numbers: an asymmetric core, and exponential tails."""

from dataclasses import dataclass

import numpy as np

from physics.pulse import ImpulseResponse, two_piece_pulse
from recordings.refusal import Refusal

# Steps to a bin: a power of two, so that bins hold a whole number of steps; and so many to the steepest flank.
STEPS_PER_BIN = 16
STEPS_PER_FLANK = 8
MOST_STEPS_PER_BIN = 256
LONGEST_BINS = 1000


@dataclass(frozen=True)
class Tail:
    """share: part of the photons that is delayed exponentially with mean tau_s."""

    tau_s: float
    share: float


@dataclass(frozen=True)
class PulseShape:
    """Two half Gaussians that rise and fall with these standard deviations, mode at time 0, with tails.

    Of the photons a share is delayed by each tail; the first tail first, so that shares are not exclusive.
    """

    rise_s: float
    fall_s: float
    tails: tuple[Tail, ...] = ()

    def __post_init__(self) -> None:
        for name, value in (("rise_s", self.rise_s), ("fall_s", self.fall_s)):
            if not (np.isfinite(value) and value > 0):
                raise Refusal(f"pulse: {name} is {value}, expected positive, finite seconds")
        for i, tail in enumerate(self.tails):
            if not (np.isfinite(tail.tau_s) and tail.tau_s > 0):
                raise Refusal(f"pulse: tails[{i}].tau_s is {tail.tau_s}, expected positive, finite seconds")
            if not 0 <= tail.share <= 1:
                raise Refusal(f"pulse: tails[{i}].share is {tail.share}, expected 0 to 1")

    def sampled(self, bin_width_s: float) -> ImpulseResponse:
        """The response in steps of which a bin holds a whole number."""
        parts = {"rise_s": self.rise_s, "fall_s": self.fall_s}
        parts |= {f"tails[{i}].tau_s": tail.tau_s for i, tail in enumerate(self.tails)}
        for name, value in parts.items():
            if value > LONGEST_BINS * bin_width_s:
                long = f"{value:g} s, {value / bin_width_s:g} bins long"
                raise Refusal(f"pulse: {name} is {long}, expected at most {LONGEST_BINS} bins")
        per_bin = STEPS_PER_BIN
        while per_bin < MOST_STEPS_PER_BIN and bin_width_s / per_bin * STEPS_PER_FLANK > min(self.rise_s, self.fall_s):
            per_bin *= 2
        pulse = two_piece_pulse(self.rise_s, self.fall_s, bin_width_s / per_bin)
        for tail in self.tails:
            pulse = pulse.with_tail(tail.tau_s, tail.share)
        return pulse

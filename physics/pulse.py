"""The impulse response of laser and detector, and how a pulse fills the bins of a histogram."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.constants import speed_of_light
from scipy.signal import lfilter
from scipy.special import ndtr

from recordings.refusal import Refusal

# The pulse is followed to this many standard deviations of its core and time constants of its tail: 1e-9 is
# left out.
CORE_REACH = 6.0
TAIL_REACH = 20.0


@dataclass(frozen=True, eq=False)
class ImpulseResponse:
    """When a photon is registered, relative to its nominal arrival.

    time_s: (N,) seconds, even steps; 0 is the nominal arrival.
    probability: (N,) probability of each step, spread evenly over the step that is centred at its time; sums
    to 1.
    """

    time_s: np.ndarray
    probability: np.ndarray

    @cached_property
    def _edges(self) -> tuple[np.ndarray, np.ndarray]:
        """Edges of the steps (N + 1,) in seconds, and the probability of having been registered by then."""
        step = (self.time_s[-1] - self.time_s[0]) / (len(self.time_s) - 1)
        edges = self.time_s[0] + step * (np.arange(len(self.time_s) + 1) - 0.5)
        return edges, np.concatenate([[0.0], np.cumsum(self.probability, dtype=float)])

    def cumulative(self, time_s: np.ndarray) -> np.ndarray:
        """Probability that a photon is registered before `time_s` after its nominal arrival, any shape."""
        return np.interp(time_s, *self._edges)

    def in_bins(self, arrival_s: np.ndarray, bins: int, bin_width_s: float) -> np.ndarray:
        """(..., bins) share of a pulse in each bin, for nominal arrivals (...) after the start of bin 0.

        Exact for this response: differences of its cumulative, linear within a step.
        """
        edges = np.arange(bins + 1) * bin_width_s
        return np.diff(self.cumulative(edges - np.asarray(arrival_s, float)[..., None]), axis=-1)


def arrival(range_m: np.ndarray, time_zero_s: np.ndarray) -> np.ndarray:
    """Nominal arrival, seconds from the start of bin 0, of light that returns from a target at `range_m`."""
    return time_zero_s + 2 * np.asarray(range_m) / speed_of_light


def tailed_pulse(rise_s: float, fall_s: float, tail_s: float, tail_share: float, step_s: float) -> ImpulseResponse:
    """A core of two half Gaussians, rising and falling with these standard deviations, with a tail.

    A share of the photons is delayed once more, exponentially with mean `tail_s`: carriers that diffuse into
    the avalanche region, and a laser that turns off slowly. The mode of the core is at time 0; steps of
    `step_s`.
    """
    if min(rise_s, fall_s, tail_s, step_s) <= 0 or not 0 <= tail_share <= 1:
        raise Refusal(
            f"pulse: rise {rise_s}, fall {fall_s}, tail {tail_s}, step {step_s} s, tail share {tail_share}, "
            "expected positive times and a share in 0..1"
        )
    steps = np.arange(
        -np.ceil(CORE_REACH * rise_s / step_s),
        np.ceil((CORE_REACH * fall_s + TAIL_REACH * tail_s) / step_s) + 1,
    )
    core = np.diff(_two_piece_normal(step_s * (np.append(steps, steps[-1] + 1) - 0.5), rise_s, fall_s))
    kept = np.exp(-step_s / tail_s)
    tail = lfilter([1 - kept], [1, -kept], core)
    probability = (1 - tail_share) * core + tail_share * tail
    return ImpulseResponse(steps * step_s, probability / probability.sum())


def _two_piece_normal(time_s: np.ndarray, rise_s: float, fall_s: float) -> np.ndarray:
    """Cumulative of the two-piece normal distribution, mode at 0 (Wallis 2014, Stat. Sci. 29, 106)."""
    before = 2 * rise_s / (rise_s + fall_s) * ndtr(np.minimum(time_s, 0) / rise_s)
    after = fall_s / (rise_s + fall_s) * (2 * ndtr(np.maximum(time_s, 0) / fall_s) - 1)
    return before + after

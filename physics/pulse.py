"""The impulse response of laser and detector, and how a pulse fills the bins of a histogram."""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from scipy.constants import speed_of_light
from scipy.special import ndtr

from physics.waits import late, reach
from recordings.refusal import Refusal

# The pulse is followed to this many standard deviations of its core: 1e-9 is left out.
CORE_REACH = 6.0
# Less of a step than this is nothing, and its square would be too small for a number.
NARROWEST = 1e-9
# An even delay of less than this part of a step, or of the normal one's deviation, would be lost to rounding where it
# is divided by; a normal one of as much variance differs from it by a hundred-thousandth.
SHORTEST, SLIGHT = 1e-3, 0.1


@dataclass(frozen=True, eq=False)
class ImpulseResponse:
    """When a photon is registered, relative to its nominal arrival.

    time_s: (N,) seconds, even steps; 0 is the nominal arrival.
    probability: (N,) probability of each step, spread evenly over the step that is centred at its time; sums
    to 1.
    """

    time_s: np.ndarray
    probability: np.ndarray

    @property
    def step_s(self) -> float:
        """Width of a step, seconds."""
        return float(self.time_s[-1] - self.time_s[0]) / (len(self.time_s) - 1)

    @cached_property
    def edges(self) -> np.ndarray:
        """(N + 1,) edges of the steps, seconds."""
        return float(self.time_s[0]) + self.step_s * (np.arange(len(self.time_s) + 1) - 0.5)

    @cached_property
    def edge_cumulative(self) -> np.ndarray:
        """(N + 1,) probability of having been registered by each edge."""
        return np.concatenate([[0.0], np.cumsum(self.probability, dtype=float)])

    def cumulative(self, time_s: np.ndarray) -> np.ndarray:
        """Probability that a photon is registered before `time_s` after its nominal arrival, any shape."""
        return np.interp(time_s, self.edges, self.edge_cumulative)

    def integral(self, time_s: np.ndarray) -> np.ndarray:
        """Integral of the cumulative up to `time_s`, seconds: quadratic within a step, linear after the last."""
        edges, cumulative = self.edges, self.edge_cumulative
        until = np.concatenate([[0.0], np.cumsum((cumulative[1:] + cumulative[:-1]) / 2 * self.step_s)])
        inside = np.clip(time_s, edges[0], edges[-1])
        step = np.minimum(((inside - edges[0]) / self.step_s).astype(int), len(self.probability) - 1)
        part = inside - edges[step]
        quadratic = until[step] + part * (cumulative[step] + self.probability[step] * part / (2 * self.step_s))
        return quadratic + cumulative[-1] * np.maximum(time_s - edges[-1], 0)

    def in_bins(self, arrival_s: np.ndarray, bins: int, bin_width_s: float) -> np.ndarray:
        """(..., bins) share of a pulse in each bin, for nominal arrivals (...) after the start of bin 0.

        Exact for this response: differences of its cumulative, linear within a step.
        """
        edges = np.arange(bins + 1) * bin_width_s
        return np.diff(self.cumulative(edges - np.asarray(arrival_s, float)[..., None]), axis=-1)

    def in_steps(self, step_s: float) -> "ImpulseResponse":
        """The same response in steps of another width, from the same start: its cumulative is kept at their edges."""
        steps = max(int(np.ceil((self.edges[-1] - self.edges[0]) / step_s - NARROWEST)), 2)
        cumulative = self.cumulative(self.edges[0] + step_s * np.arange(steps + 1))
        return ImpulseResponse(self.edges[0] + step_s * (np.arange(steps) + 0.5), np.diff(cumulative))

    def without_ends(self, most: float) -> "ImpulseResponse":
        """The same response less ends that hold no more than `most` each; what is left sums to what all did."""
        after = np.searchsorted(self.edge_cumulative, most, side="right") - 1
        before = np.searchsorted(self.edge_cumulative, self.edge_cumulative[-1] - most)
        kept = slice(max(int(after), 0), max(int(before), int(after) + 2))
        inner = self.probability[kept]
        return ImpulseResponse(self.time_s[kept], inner * (self.probability.sum() / inner.sum()))

    def blurred(self, sigma_s: float, even: float = 0.0) -> "ImpulseResponse":
        """The response convolved with the density of `blurring`; exact at the edges if even within its steps."""
        kernel = blurring(self.step_s, sigma_s, even)
        reach, probability = len(kernel) // 2, np.convolve(self.probability, kernel)
        times = self.time_s[0] + self.step_s * np.arange(-reach, len(self.time_s) + reach)
        return ImpulseResponse(times, probability * (self.probability.sum() / probability.sum()))

    def with_tail(self, tail_s: float, share: float, heavy: float = 0.0) -> "ImpulseResponse":
        """The response where a share of the photons is delayed once more, exponentially with mean `tail_s`.

        heavy: of `waits.waiting`; other than 0 for a plateau, a ramp, or a power law. Exact for this response, whose
        photons are spread evenly over each step; longer by all delays but the longest (`waits.reach`).
        """
        if not (tail_s > 0 and 0 <= share <= 1):
            raise Refusal(f"tail: time constant {tail_s} s, share {share}, expected above 0 and 0 to 1")
        more = int(np.ceil(reach(tail_s, heavy) / self.step_s))
        core = np.concatenate([self.probability, np.zeros(more)])
        mixed = (1 - share) * core + share * late(core, self.step_s, tail_s, heavy)
        times = self.time_s[0] + self.step_s * np.arange(len(core))
        return ImpulseResponse(times, mixed * (self.probability.sum() / mixed.sum()))


def arrival(range_m: np.ndarray, time_zero_s: np.ndarray) -> np.ndarray:
    """Nominal arrival, seconds from the start of bin 0, of light that returns from a target at `range_m`."""
    return time_zero_s + 2 * np.asarray(range_m) / speed_of_light


def blurring(step_s: float, sigma_s: float, even: float = 0.0) -> np.ndarray:
    """(2 N + 1,) share of light, even over a step, that delays of this standard deviation put into each step about it.

    even: part of its variance that comes of a delay which is anything up to a longest alike; the rest is normal.
    """
    sigma, longest = max(sigma_s * np.sqrt(1 - even) / step_s, NARROWEST), sigma_s * np.sqrt(3 * even) / step_s
    if longest < max(SHORTEST, SLIGHT * sigma):
        sigma, longest = max(sigma_s / step_s, NARROWEST), 0.0
    reach = int(np.ceil(CORE_REACH * sigma + longest)) + 1
    at = np.arange(-reach - 1, reach + 2.0)
    # The share of a step that falls into each other is the second difference of the integral of the delay's cumulative.
    if longest:
        late, soon = (_integral_twice((at + end) / sigma, sigma) for end in (longest, -longest))
        heaped = (late - soon) / (2 * longest)
    else:
        heaped = _integral(at / sigma, sigma)
    return np.maximum(np.diff(heaped, 2), 0)


def _integral(z: np.ndarray, sigma: float) -> np.ndarray:
    """Integral of the cumulative of a normal deviate up to z of its standard deviations."""
    return sigma * (z * ndtr(z) + np.exp(-0.5 * z**2) / np.sqrt(2 * np.pi))


def _integral_twice(z: np.ndarray, sigma: float) -> np.ndarray:
    """Integral of that."""
    return 0.5 * sigma**2 * ((z**2 + 1) * ndtr(z) + z * np.exp(-0.5 * z**2) / np.sqrt(2 * np.pi))


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
    return two_piece_pulse(rise_s, fall_s, step_s).with_tail(tail_s, tail_share)


def two_piece_pulse(rise_s: float, fall_s: float, step_s: float) -> ImpulseResponse:
    """The core alone."""
    steps = np.arange(-np.ceil(CORE_REACH * rise_s / step_s), np.ceil(CORE_REACH * fall_s / step_s) + 1)
    core = np.diff(_two_piece_normal(step_s * (np.append(steps, steps[-1] + 1) - 0.5), rise_s, fall_s))
    return ImpulseResponse(steps * step_s, core / core.sum())


def _two_piece_normal(time_s: np.ndarray, rise_s: float, fall_s: float) -> np.ndarray:
    """Cumulative of the two-piece normal distribution, mode at 0 (Wallis 2014, Stat. Sci. 29, 106)."""
    before = 2 * rise_s / (rise_s + fall_s) * ndtr(np.minimum(time_s, 0) / rise_s)
    after = fall_s / (rise_s + fall_s) * (2 * ndtr(np.maximum(time_s, 0) / fall_s) - 1)
    return before + after


@lru_cache(maxsize=8)
def longer(pulse: ImpulseResponse, sigma_s: float) -> ImpulseResponse:
    """The response convolved with a normal density: the same object for the same, which keeps what is made of it."""
    return pulse.blurred(sigma_s) if sigma_s else pulse

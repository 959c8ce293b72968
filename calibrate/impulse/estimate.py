"""The impulse response of laser and detector from frames of known geometry, finer than a bin, with its errors."""

from dataclasses import dataclass

import numpy as np

from calibrate.impulse.cells import phase_gap
from calibrate.impulse.search import Found, determined, search, shape_of
from calibrate.impulse.shape import Shape, normalised
from calibrate.impulse.sweep import Sweep
from physics.pulse import ImpulseResponse
from recordings.progress import Progress, silent
from recordings.refusal import Refusal

STEPS_PER_BIN = 8
MOST_STEPS_PER_BIN = 32
# Where arrivals leave more than this of a bin unvisited, counts do not tell what the response does in there.
WIDEST_GAP = 0.5


@dataclass(frozen=True, eq=False)
class ImpulseEstimate:
    """A response, or one for each zone, and what was estimated with it.

    time_s: (N,) seconds after the nominal arrival, steps of a part of a bin. probability, sigma: (N,), or (P, N) where
    each zone has its own; probability of each step, and its standard error. delay_s, delay_sigma_s: (P,) seconds by
    which zones are later than their time zeros say; their mean is 0, and they are 0 where each zone has a response of
    its own, which holds the delay. bin_width_s, bin_width_sigma_s: seconds; the error is 0 where the width was given.
    gain, pedestal: (F, P) counts per unit of light, and counts per bin. degrees: how many numbers of the response the
    counts determine; by zone where each has its own, as the rest. scatter: variance of the counts in units of the one
    expected. noise: relative error of the model's counts that explains the rest. jitter_s: standard
    deviation of a frame's own delay, that of one zone and frame. settled: whether the search ended. gap_bins: widest
    part of a bin in which no frame's light arrives. shape: the steps.
    """

    time_s: np.ndarray
    probability: np.ndarray
    sigma: np.ndarray
    delay_s: np.ndarray
    delay_sigma_s: np.ndarray
    bin_width_s: float
    bin_width_sigma_s: float
    gain: np.ndarray
    pedestal: np.ndarray
    degrees: np.ndarray
    scatter: np.ndarray
    noise: np.ndarray
    jitter_s: np.ndarray
    settled: bool
    gap_bins: float
    shape: Shape

    def response(self, zone: int | None = None) -> ImpulseResponse:
        """The response of a zone; of all, or the mean of all, where None."""
        if self.probability.ndim == 1:
            return ImpulseResponse(self.time_s, self.probability)
        row = self.probability.mean(axis=0) if zone is None else self.probability[zone]
        return ImpulseResponse(self.time_s, row / row.sum())


def fit_impulse(
    sweep: Sweep,
    *,
    per_zone: bool = False,
    fit_bin_width: bool = False,
    steps_per_bin: int = STEPS_PER_BIN,
    zones: list[int] | None = None,
    progress: Progress = silent,
) -> ImpulseEstimate:
    """The response of largest posterior probability, and errors from its curvature.

    Counts are those of first photons (`calibrate.impulse.likelihood`) of a light that is linear in the response. Free
    are: the logarithm of the response, a spline whose smoothness is that of largest evidence; gain and pedestal of
    every frame and zone, since near the sensor light does not fall as 1/r² and a near target shades the room's; a
    small delay of every frame and zone, whose variance is that of largest evidence too, since arrival depends on
    signal and no arm stands still; a delay of each zone where they share a response; the bin width where
    `fit_bin_width`.

    Nothing tells a late response from a late time zero. Time zero is taken as it is given, and the response holds what
    is left; between zones that share a response the delays have the mean 0.

    Where the counts scatter more than photons do, they are taken to have a relative error on top, the same for all
    cells, and weigh as much less. Where all frames' light arrives at about the same place within a bin, counts tell the
    sums over bins and no more; the errors say so, whatever smoothness would suggest.

    zones: those that take part, all where None; delays, gains and pedestals are theirs. Raises `Refusal` where there is
    nothing to estimate from, as where no light of the scene reaches one of them in some frame.
    """
    if not 1 <= steps_per_bin <= MOST_STEPS_PER_BIN:
        raise Refusal(f"steps_per_bin is {steps_per_bin}, expected 1 to {MOST_STEPS_PER_BIN}")
    if not sweep.counts.any():
        raise Refusal("counts are 0 in all frames, expected light of the scene")
    if per_zone and fit_bin_width:
        raise Refusal("the bin width cannot be estimated zone by zone, expected one response for all zones")
    shape = shape_of(sweep, steps_per_bin)
    zones = list(range(sweep.counts.shape[1])) if zones is None else zones
    groups = [[zone] for zone in zones] if per_zone else [zones]
    found = [search(sweep, shape, g, fit_bin_width) for g in progress(groups, len(groups), "fitting responses")]
    return estimate_of(sweep, shape, found, per_zone)


def estimate_of(sweep: Sweep, shape: Shape, found: list[Found], per_zone: bool) -> ImpulseEstimate:
    """What the searches found, in seconds."""
    width = sweep.bin_width_s * (1 + found[0].state.stretch)
    step = width / shape.per_bin
    curves = [response_and_sigma(shape, f) for f in found]
    probability, sigma, degrees = (np.array([c[i] for c in curves]) for i in range(3))
    covariance = np.linalg.inv(found[0].information)
    k, p = shape.basis.shape[1], sum(f.state.log_gain.shape[1] for f in found)
    delays = 0 if per_zone or p == 1 else p
    delay_sigma = np.sqrt(np.diag(covariance)[k : k + delays]) if delays else np.zeros(p)
    width_sigma = sweep.bin_width_s * np.sqrt(covariance[-1, -1]) if found[0].problem.clock else 0.0
    scatter, noise = (np.array([getattr(f, name) for f in found]) for name in ("scatter", "noise"))
    jitter = np.array([f.problem.jitter for f in found]) * step
    if not per_zone:
        several = (probability, sigma, degrees, scatter, noise, jitter)
        probability, sigma, degrees, scatter, noise, jitter = (a[0] for a in several)
    return ImpulseEstimate(
        time_s=shape.offsets * step,
        probability=probability,
        sigma=sigma,
        delay_s=np.concatenate([f.state.delay for f in found]) * step,
        delay_sigma_s=delay_sigma * step,
        bin_width_s=width,
        bin_width_sigma_s=float(width_sigma),
        gain=np.exp(np.concatenate([f.state.log_gain for f in found], axis=1)),
        pedestal=np.exp(np.concatenate([f.state.log_pedestal for f in found], axis=1)),
        degrees=degrees,
        scatter=scatter,
        noise=noise,
        jitter_s=jitter,
        settled=all(f.settled for f in found),
        gap_bins=phase_gap(found[0].problem.cells, shape.per_bin),
        shape=shape,
    )


def response_and_sigma(shape: Shape, found: Found) -> tuple[np.ndarray, np.ndarray, float]:
    """(N,) response and its standard error, and the number of directions that the counts determine."""
    basis = shape.basis
    k = basis.shape[1]
    response = normalised(basis @ found.state.coefficients)
    tangent = response[:, None] * (basis - response @ basis)
    covariance = np.linalg.inv(found.information)
    sigma = np.sqrt(np.einsum("ik,kl,il->i", tangent, covariance[:k, :k], tangent))
    gap = phase_gap(found.problem.cells, shape.per_bin)
    if gap > WIDEST_GAP:
        sigma = np.hypot(sigma, unseen(response, max(round(gap * shape.per_bin), 1)))
    return response, sigma, determined(found.problem, found.smoothness, covariance)


def unseen(response: np.ndarray, steps: int) -> np.ndarray:
    """(N,) standard error of steps of which counts tell no more than the sum over so many neighbours.

    That of one share of the sum where all ways to share it are alike (Dirichlet distribution, all parameters 1).
    """
    mean = np.convolve(response, np.full(steps, 1 / steps), "same")
    return mean * np.sqrt((steps - 1) / (steps + 1))

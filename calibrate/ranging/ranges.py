"""The distance of largest likelihood, of every frame and zone by itself."""

from dataclasses import dataclass

import numpy as np

from calibrate.impulse.likelihood import Counted, exposure
from calibrate.ranging.templates import Templates
from recordings.refusal import Refusal

MOST_STEPS = 60
# The search ends where no distance moves by more than this share of the templates' spacing.
SETTLED = 1e-4
# Logarithms of gain and pedestal move by no more than this in a step, distances by no more than so many templates.
LONGEST, FARTHEST = 1.0, 4.0
# A pedestal of half a count in the histogram is held by nothing else.
LOOSE = 1e-6


@dataclass(frozen=True, eq=False)
class Ranges:
    """Distances of F frames and P zones, each from its own histogram.

    range_m: (F, P) metres, NaN where nothing was counted or the best distance is not between the templates. sigma_m:
    (F, P) standard error by photon noise, with gain and pedestal unknown: the Cramér-Rao bound, if the templates are
    right. gain, pedestal: (F, P) counts of signal in all, and counts per bin, as a detector without loss would see
    them. deviance: (F, P) of a cell, about 1 where the templates are right.
    """

    range_m: np.ndarray
    sigma_m: np.ndarray
    gain: np.ndarray
    pedestal: np.ndarray
    deviance: np.ndarray


def ranges(counts: np.ndarray, templates: Templates, shots: np.ndarray | float | None = None) -> Ranges:
    """The distance at which a surface that fills a zone makes its histogram (F, P, T) likeliest.

    Counts are Poisson about gain · template(distance) + pedestal; where the laser shots of a frame, (F,) or one number,
    are given, those of first photons (`calibrate.impulse.likelihood`), so that pile-up is no error of distance. Gain
    and pedestal are free. Scoring steps with Levenberg's damping, all histograms at once. It begins at the template
    that is most like the histogram.
    """
    counts = np.asarray(counts, float)
    _, zones, bins = templates.expected.shape
    if counts.ndim != 3 or counts.shape[1:] != (zones, bins):
        raise Refusal(f"counts have shape {counts.shape}, expected (F, {zones}, {bins}) as the templates")
    if not (np.isfinite(counts).all() and (counts >= 0).all()):
        raise Refusal("counts hold NaN, infinity or values below 0, expected photon counts")
    shots = None if shots is None else np.broadcast_to(np.asarray(shots, float), len(counts))
    alive = exposure(counts, shots).reshape(-1, bins)
    limit = np.full(len(counts), np.inf) if shots is None else shots
    seen = Counted(counts.reshape(-1, bins), alive, np.repeat(limit, zones)[:, None])
    zone = np.tile(np.arange(zones), len(counts))
    state = _start(seen, templates, zone)
    step = templates.distance_m[1] - templates.distance_m[0]
    damping = np.full(len(zone), 1e-4)
    likelihood = _likelihood(seen, templates, zone, state)
    for _ in range(MOST_STEPS):
        change = _step(seen, templates, zone, state, damping, step)
        ahead = state + change
        ahead[:, 0] = np.clip(ahead[:, 0], *templates.distance_m[[1, -2]])
        after = _likelihood(seen, templates, zone, ahead)
        better = after >= likelihood
        state, likelihood = np.where(better[:, None], ahead, state), np.where(better, after, likelihood)
        damping = np.where(better, damping / 10, damping * 10)
        if not (np.abs(change[:, 0]) > SETTLED * step).any():
            break
    information, _ = _information(seen, templates, zone, state)
    sigma = np.sqrt(np.linalg.inv(information + np.diag([0, LOOSE, LOOSE]))[:, 0, 0])
    low, high = templates.distance_m[[1, -2]] + np.array([1, -1]) * SETTLED * step
    lost = (seen.counts.sum(axis=1) == 0) | (state[:, 0] < low) | (state[:, 0] > high)
    rate = _rate(templates, zone, state)[0]
    deviance = seen.deviance(rate).mean(axis=1)
    shape = counts.shape[:2]
    return Ranges(
        range_m=np.where(lost, np.nan, state[:, 0]).reshape(shape),
        sigma_m=np.where(lost, np.inf, sigma).reshape(shape),
        gain=np.exp(state[:, 1]).reshape(shape),
        pedestal=np.exp(state[:, 2]).reshape(shape),
        deviance=deviance.reshape(shape),
    )


def _start(seen: Counted, templates: Templates, zone: np.ndarray) -> np.ndarray:
    """(N, 3) distance, logarithms of gain and pedestal: the template whose root is most like the histogram's."""
    made_good = seen.counts / np.maximum(seen.alive, 0.02)
    pedestal = np.median(made_good, axis=1)
    above = np.maximum(np.sqrt(made_good) - np.sqrt(pedestal)[:, None], 0)
    root = np.sqrt(templates.expected)
    root /= np.maximum(np.linalg.norm(root, axis=2, keepdims=True), 1e-12)
    best = np.zeros(len(zone), int)
    for p in np.unique(zone):
        own = zone == p
        best[own] = np.argmax(above[own] @ root[1:-1, p].T, axis=1) + 1
    gain = np.maximum((made_good - pedestal[:, None]).sum(axis=1), 1.0)
    return np.stack([templates.distance_m[best], np.log(gain), np.log(pedestal + 0.5)], axis=1)


def _rate(templates: Templates, zone: np.ndarray, state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rates (N, T) and their derivatives (N, T, 3) by distance and the logarithms of gain and pedestal."""
    share, slope = templates.at(zone, state[:, 0])
    gain, pedestal = np.exp(state[:, 1:]).T[..., None]
    signal = gain * share
    level = np.broadcast_to(pedestal, share.shape)
    return signal + pedestal, np.stack([gain * slope, signal, level], axis=2)


def _information(
    seen: Counted, templates: Templates, zone: np.ndarray, state: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(N, 3, 3) expected information, and (N, 3) score."""
    rate, slopes = _rate(templates, zone, state)
    first, second = seen.score_and_information(rate)
    return np.einsum("nti,nt,ntj->nij", slopes, second, slopes, optimize=True), np.einsum("nti,nt->ni", slopes, first)


def _step(
    seen: Counted, templates: Templates, zone: np.ndarray, state: np.ndarray, damping: np.ndarray, step: float
) -> np.ndarray:
    """(N, 3) a damped scoring step."""
    information, score = _information(seen, templates, zone, state)
    diagonal = np.einsum("nii->ni", information)
    held = information + np.eye(3) * (damping[:, None] * diagonal + LOOSE)[:, None]
    longest = np.array([FARTHEST * step, LONGEST, LONGEST])
    return np.clip(np.linalg.solve(held, score[..., None])[..., 0], -longest, longest)


def _likelihood(seen: Counted, templates: Templates, zone: np.ndarray, state: np.ndarray) -> np.ndarray:
    """(N,) log likelihood of each histogram."""
    return seen.log_likelihood(_rate(templates, zone, state)[0]).sum(axis=1)

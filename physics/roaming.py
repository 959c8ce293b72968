"""Pulses whose place in a frame nobody knows beforehand: what the frame itself says of where they are.

Where in the window the pulse of frame f is, one of K places or none at all, is a hidden number of the frame's. With
counts n over zones and bins, μ expected without it and a·s_k more where it is at place k,

    L_fk = Σ n ln(1 + a s_k / μ) - Σ a s_k

is the log-likelihood ratio of the place, and the frame's evidence for the whole of it ln((1 - q) + q/K Σ_k exp L_fk),
where q is the share of frames that hold a pulse: a finite mixture (McLachlan and Peel 2000, chapter 1).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numba import njit
from scipy.special import logsumexp

from physics.by_value import kept_by_value
from physics.clock import Clock
from physics.pulse import ImpulseResponse

PLACES_PER_BIN = 2
# A bin that holds less of a pulse than this is not looked at.
LEAST_SHARE = 1e-5
LEAST_COUNTS = 1e-3
NO_CHANCE = 1e-9
# The sensor's own pulse is faint beside another where it would have less than this part of its counts there.
FAINT = 0.1
# A frame may be this much dimmer or brighter than expected.
MOST_GAIN = 0.5
# Up to here a few terms of a series are the logarithm, and take less time.
SMALL = 0.02
# As many results are kept as a fit asks for between its steps, but for those by which slopes are seen.
RECENT = 16


@dataclass(frozen=True, eq=False)
class Roaming:
    """Where the pulse of each frame may be.

    chances: (F, K) of each place, less than 1 in sum where there may be none. evidence: (F,) twice the logarithm of how
    much more probable the frame's counts are with a pulse somewhere than without. added: (F, P, T) mean counts of it.
    flattery: (F,) deviance by which `added`, which follows the counts, fits them better than their evidence allows.
    blur: (F,) deviance by which places that stay uncertain leave counts scattered beyond Poisson's law.
    by_counts, by_present: (F, P) and (F,) derivatives of half the evidence.
    """

    chances: np.ndarray
    evidence: np.ndarray
    added: np.ndarray
    flattery: np.ndarray
    blur: np.ndarray
    by_counts: np.ndarray
    by_present: np.ndarray


# A fit asks for the same counts as they add to others, for what they own up to, and for its slopes.
@kept_by_value(RECENT)
def roaming(
    recorded: np.ndarray,
    expected: np.ndarray,
    background: np.ndarray | float,
    clock: Clock,
    counts: np.ndarray,
    present: float,
) -> Roaming:
    """What frames say of where a pulse is in each, at the same time in all zones.

    recorded, expected: (F, P, T) counts, those expected without the pulse. background: of these, what no laser sent.
    counts: (P,) of the pulse. present: share of frames that hold one. A frame's own brightness is taken out first, so
    that a bright frame's peak is no pulse. What it gives is to be read only.
    """
    mean = np.maximum(_at_its_brightness(recorded, expected, background), LEAST_COUNTS)
    shares = pulses_in_bins(clock.pulse, clock.bins, clock.bin_width_s)
    first, last = _extents(shares)
    # Zones that count nothing at all are dead, and say nothing.
    alive = recorded.any(axis=(0, 2))
    heard = np.where(alive, counts, 0.0)
    seen = np.ascontiguousarray(recorded, float)
    ratio = _ratios(seen, mean, heard, shares, first, last).sum(axis=1)
    prior = np.log(present / len(shares))
    evidence = np.logaddexp(np.log1p(-min(present, 1 - 1e-12)), prior + logsumexp(ratio, axis=1))
    chances = np.exp(ratio + prior - evidence[:, None])
    added = (chances @ shares)[:, None] * counts[:, None]
    reached = (recorded * np.log1p(added / mean) - added)[:, heard > 0].sum(axis=(1, 2))
    by_counts = np.where(alive, _slopes(seen, mean, heard, shares, first, last, chances), 0.0)
    there = chances.sum(axis=1)
    by_present = there / present - (1 - there) / max(1 - present, 1e-12)
    varies = (chances @ shares**2)[:, None] * heard[:, None] ** 2 - np.where(heard[:, None] > 0, added, 0) ** 2
    blur = (varies / (mean + added)).sum(axis=(1, 2))
    return Roaming(chances, 2 * evidence, added, 2 * (reached - evidence), blur, by_counts, by_present)


def clear_evidence(
    recorded: np.ndarray,
    expected: np.ndarray,
    background: np.ndarray | float,
    clock: Clock,
    counts: float,
    present: Sequence[float],
) -> np.ndarray:
    """(N, 1 + P) evidence for so many counts in shares `present` (N,) of frames, in all zones alike and each alone.

    Only places count where the sensor's own pulse is faint beside it: whatever is wrong about surfaces shows where they
    are, another emitter's pulse anywhere.
    """
    mean = np.maximum(_at_its_brightness(recorded, expected, background), LEAST_COUNTS)
    shares = pulses_in_bins(clock.pulse, clock.bins, clock.bin_width_s)
    heard = np.where(recorded.any(axis=(0, 2)), counts, 0.0)
    ratio = _ratios(np.ascontiguousarray(recorded, float), mean, heard, shares, *_extents(shares))
    there = np.maximum(mean - background, 0) @ (shares / np.maximum((shares**2).sum(axis=1), LEAST_SHARE)[:, None]).T
    clear = (there < FAINT * counts) | (heard == 0)[:, None]
    alike = np.where(clear.all(axis=1), ratio.sum(axis=1), -np.inf)
    alone = np.where(clear & (heard > 0)[:, None], ratio, -np.inf)
    some = np.array([_mean(one) for one in (alike, *np.moveaxis(alone, 1, 0))])
    return np.array([2 * np.logaddexp(np.log1p(-share), np.log(share) + some).sum(axis=1) for share in present])


def _mean(ratio: np.ndarray) -> np.ndarray:
    """(F,) logarithm of the mean likelihood ratio over those places (F, K) that are not ruled out; 0 where all are."""
    many = np.isfinite(ratio).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        found = logsumexp(ratio, axis=1) - np.log(many)
    return np.where(many > 0, found, 0.0)


@lru_cache(maxsize=4)
def pulses_in_bins(pulse: ImpulseResponse, bins: int, bin_width_s: float) -> np.ndarray:
    """(K, T) share of a pulse in each bin, for K places all over the window; not to be written to."""
    arrivals_s = (np.arange(PLACES_PER_BIN * bins) + 0.5) * bin_width_s / PLACES_PER_BIN
    return pulse.in_bins(arrivals_s, bins, bin_width_s)


def _extents(shares: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(K,) each: the first bin that holds any of a pulse at each place, and the one after the last."""
    held = shares > LEAST_SHARE
    return np.argmax(held, axis=1), shares.shape[1] - np.argmax(held[:, ::-1], axis=1)


def _at_its_brightness(recorded: np.ndarray, expected: np.ndarray, background: np.ndarray | float) -> np.ndarray:
    """Expected counts with the signal of each frame as bright as the frame says."""
    signal, mean = np.maximum(expected - background, 0), np.maximum(expected, LEAST_COUNTS)
    score = (signal * (recorded / mean - 1)).sum(axis=(1, 2))
    gain = score / np.maximum((signal**2 / mean).sum(axis=(1, 2)), LEAST_COUNTS)
    return expected + np.clip(gain, -MOST_GAIN, MOST_GAIN)[:, None, None] * signal


@njit(nogil=True, cache=True, error_model="numpy")
def _ratios(recorded, mean, counts, shares, first, last):
    """(F, P, K) log-likelihood ratios."""
    frames, zones, bins = recorded.shape
    found = np.zeros((frames, zones, len(shares)))
    whole = np.array([shares[k, first[k] : last[k]].sum() for k in range(len(shares))])
    # Bins that hold counts, how many of them come before each, their counts, and by how much one more would be more.
    held, before, some, part = np.empty(bins, np.int64), np.empty(bins + 1, np.int64), np.empty(bins), np.empty(bins)
    for f in range(frames):
        for p in range(zones):
            if counts[p] <= 0:
                continue
            many = 0
            for t in range(bins):
                before[t] = many
                if recorded[f, p, t] > 0:
                    held[many], some[many], part[many] = t, recorded[f, p, t], counts[p] / mean[f, p, t]
                    many += 1
            before[bins] = many
            for k in range(len(shares)):
                total = -counts[p] * whole[k]
                for i in range(before[first[k]], before[last[k]]):
                    total += some[i] * _log1p(part[i] * shares[k, held[i]])
                found[f, p, k] = total
    return found


@njit(nogil=True, cache=True, error_model="numpy")
def _log1p(x):
    """Logarithm of 1 + x, to 3e-13 of it where that is small: most bins hold little of a pulse."""
    if x > SMALL:
        return np.log1p(x)
    return x * (1 - x * (1 / 2 - x * (1 / 3 - x * (1 / 4 - x * (1 / 5 - x * (1 / 6 - x / 7))))))


@njit(nogil=True, cache=True, error_model="numpy")
def _slopes(recorded, mean, counts, shares, first, last, chances):
    """(F, P) derivative of the frame's log-evidence by each zone's counts."""
    frames, zones, _ = recorded.shape
    found = np.zeros((frames, zones))
    for f in range(frames):
        for k in range(len(shares)):
            if chances[f, k] < NO_CHANCE:
                continue
            for p in range(zones):
                total = 0.0
                for t in range(first[k], last[k]):
                    share = shares[k, t]
                    total += share * (recorded[f, p, t] / (mean[f, p, t] + counts[p] * share) - 1)
                found[f, p] += chances[f, k] * total
    return found

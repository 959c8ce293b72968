"""Pulses that wander out of the window and return a period later: those of an emitter with a clock of its own."""

from dataclasses import dataclass

import numpy as np
from numba import njit

from physics.pulse import ImpulseResponse
from physics.rendering import Rendering
from physics.tracks import matched_parts

# A session is crossed so many times at most, and this part of once at least: what moves less seldom leaves and returns.
# Slopes are tried in steps of so many bins over the session.
MOST_CROSSINGS, LEAST_CROSSED, STEP_BINS = 8, 0.25, 2
# Periods of emitters, in windows; so many slopes are tried with each of them.
SHORTEST, LONGEST, TRIED = 0.5, 2.0, 24


@dataclass(frozen=True)
class Returning:
    """A pulse that wanders and returns. arrival_s: one of its arrivals at time 0, from the start of bin 0. drift:
    seconds later each second. period_s: between its arrivals. evidence: as of a `physics.tracks.Track`.
    """

    arrival_s: float
    drift: float
    period_s: float
    evidence: float


def shares_of_all(
    pulse: ImpulseResponse, arrival_s: np.ndarray, period_s: float, bins: int, bin_width_s: float
) -> np.ndarray:
    """(..., bins) share in each bin of pulses that arrive at `arrival_s` (...) and a period before and after, for ever.

    Those that reach into the window at all are added up.
    """
    first = np.mod(arrival_s - pulse.edges[-1], period_s) + pulse.edges[-1]
    # One may have begun before the window and not be over.
    before = -int(np.ceil((pulse.edges[-1] - pulse.edges[0]) / period_s)) - 1
    after = int(np.ceil((bins * bin_width_s - pulse.edges[0]) / period_s))
    total = pulse.in_bins(first, bins, bin_width_s)
    for turn in range(before, after + 1):
        if turn:
            total = total + pulse.in_bins(first + turn * period_s, bins, bin_width_s)
    return total


def returning_track(excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> Returning | None:
    """The pulse that wanders out of the window and returns, and explains most of an excess; None where none may.

    excess: (F, P, T) recorded less expected counts. Lines of one slope are added up along the matched filter's output:
    of all zones, to see which slopes may be; then of each, those a period apart together. A zone's strength is its own,
    0 or more.
    """
    matched, times = matched_parts(excess, expected, rendering)
    parts, _, bins = matched.shape
    lasted = max(float(np.ptp(times)), 1e-9)
    # Pulses that move by more than a quarter of the window from part to part are like slower ones.
    most = min(MOST_CROSSINGS * bins, (parts - 1) * bins // 4)
    slopes = [float(sign * s) for s in range(int(LEAST_CROSSED * bins), most + 1, STEP_BINS) for sign in (-1, 1)]
    all_zones = np.ascontiguousarray(matched.sum(axis=1, keepdims=True))
    lines = []
    for slope in slopes:
        shifts = np.rint(slope * (times - times[0]) / lasted).astype(int)
        along, passed = _along(all_zones, shifts)
        lines.append(((along / np.sqrt(np.maximum(passed, parts / 32))).max(), slope, shifts))
    best = None
    for _, slope, shifts in sorted(lines, key=lambda line: -line[0])[:TRIED]:
        along, passed = _along(matched, shifts)
        for period in range(int(SHORTEST * bins), int(LONGEST * bins) + 1):
            evidence, first = _folded(along, passed, period, parts)
            if best is None or evidence > best[0]:
                best = (evidence, first, slope, period)
    if best is None:
        return None
    evidence, first, slope, period = best
    # Lines are numbered from the first bin less the farthest shift on.
    shift = int(np.rint(slope)) if slope > 0 else 0
    width = rendering.clock.bin_width_s
    start = (first - shift + 0.5 - slope * times[0] / lasted) * width
    return Returning(start, slope * width / lasted, period * width, evidence)


@njit(nogil=True, cache=True)
def _along(matched, shifts):
    """Sums (P, L) of N parts (N, P, T), each earlier by its shift, over all lines that meet any; how many each (L,)."""
    parts, zones, bins = matched.shape
    farthest = max(shifts.max(), 0)
    lines = farthest - min(shifts.min(), 0) + bins
    along, passed = np.zeros((zones, lines)), np.zeros(lines)
    for part in range(parts):
        first = farthest - shifts[part]
        for t in range(bins):
            passed[first + t] += 1
        for p in range(zones):
            for t in range(bins):
                along[p, first + t] += matched[part, p, t]
    return along, passed


@njit(nogil=True, cache=True)
def _folded(along, passed, period, parts):
    """Most evidence of lines a period apart together, and the first of them."""
    zones, lines = along.shape
    best, which = 0.0, 0
    for first in range(min(period, lines)):
        many = 0.0
        for line in range(first, lines, period):
            many += passed[line]
        evidence = 0.0
        for p in range(zones):
            total = 0.0
            for line in range(first, lines, period):
                total += along[p, line]
            if total > 0:
                evidence += total * total / max(many, parts / 4)
        if evidence > best:
            best, which = evidence, first
    return best, which

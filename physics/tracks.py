"""Pulses that wander evenly from frame to frame: straight lines through frames and bins with light in excess."""

from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.signal import fftconvolve

from physics.rendering import Rendering

# A session is searched in so many parts of successive frames, and so many slopes.
MOST_PARTS = 96
MOST_SLOPES = 257
# Two lines that are nowhere farther apart than this are one.
APART_BINS = 2.0
# From one frame to the next a free clock gains any remainder of many periods, at least a window long: in N frames it
# comes less far than this part of the window with a chance of 0.6 / N at most. That is a thing that moves, and what
# comes farther hardly is.
CROSSED = 0.3


@dataclass(frozen=True)
class Track:
    """A pulse that wanders. arrival_s: nominal, at time 0, from the start of bin 0. drift: seconds later each second.

    evidence: sum over zones of the squares of how many standard deviations more there is along it than expected.
    """

    arrival_s: float
    drift: float
    evidence: float


def straight_tracks(
    excess: np.ndarray,
    expected: np.ndarray,
    rendering: Rendering,
    fastest: float = np.inf,
    most: int = 4,
    way_s: np.ndarray | float = 0.0,
) -> list[Track]:
    """Where a pulse of the clock's shape would explain most of an excess, best first, `most` of them.

    excess: (F, P, T) recorded less expected counts. fastest: seconds by which it may arrive later or earlier for each
    second of the session. It crosses the window once at most. way_s: (F,) seconds by which it arrives later in each
    frame beside that, straight or not. The pulse is a matched filter for white noise (Turin
    1960, IRE Trans. Inf. Theory 6, 311), and each zone has its own strength along the line, 0 or more.
    """
    clock, bins = rendering.clock, excess.shape[-1]
    matched, times = matched_parts(excess, expected, rendering)
    parts, ways = len(times), _in_parts(np.broadcast_to(way_s, len(excess))) / clock.bin_width_s
    lasted = max(float(np.ptp(times)), 1e-9)
    reach = min(bins, int(np.ceil(min(fastest * lasted / clock.bin_width_s, bins))))
    found = []
    for slope in np.linspace(-reach, reach, min(2 * reach + 1, MOST_SLOPES)):
        shifts = np.rint(slope * (times - times[0]) / lasted + ways).astype(int)
        along, passed = _along(matched, np.clip(shifts, -bins, bins))
        # What is seen in few frames only needs more of an excess.
        sigmas = along / np.sqrt(np.maximum(passed, parts / 4))
        evidence = (np.maximum(sigmas, 0) ** 2).sum(axis=0)
        best = int(np.argmax(evidence))
        found.append((float(evidence[best]), best - bins, float(slope)))

    chosen: list[tuple[float, int, float]] = []
    for line in sorted(found, reverse=True):
        if len(chosen) == most:
            break
        ends = np.array([line[1], line[1] + line[2]])
        if all(np.abs(ends - [first, first + slope]).max() > APART_BINS for _, first, slope in chosen):
            chosen.append(line)
    return [
        Track(
            (first + 0.5 - slope * times[0] / lasted) * clock.bin_width_s, slope * clock.bin_width_s / lasted, evidence
        )
        for evidence, first, slope in chosen
    ]


def matched_parts(excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> tuple[np.ndarray, np.ndarray]:
    """(N, P, T) an excess (F, P, T) filtered by the clock's pulse, in standard deviations, and (N,) times of its parts.

    The filter is that matched to the pulse in white noise (Turin 1960, IRE Trans. Inf. Theory 6, 311).
    """
    clock, (frames, _, bins) = rendering.clock, excess.shape
    parts = np.array_split(np.arange(frames), min(frames, MOST_PARTS))
    summed, mean = (np.stack([counts[part].sum(axis=0) for part in parts]) for counts in (excess, expected))
    pulse = clock.pulse.in_bins((bins + 0.5) * clock.bin_width_s, 2 * bins + 1, clock.bin_width_s)
    pulse = pulse / max(np.sqrt((pulse**2).sum()), 1e-12)
    white = summed / np.sqrt(np.maximum(mean, 1))
    matched = np.ascontiguousarray(fftconvolve(white, pulse[None, None, ::-1], mode="same", axes=-1))
    return matched, _in_parts(rendering.light.time_s)


def _in_parts(values: np.ndarray) -> np.ndarray:
    """(N,) means over the parts of a session of values (F,) by frame."""
    return np.array([part.mean() for part in np.array_split(np.asarray(values, float), min(len(values), MOST_PARTS))])


@njit(nogil=True, cache=True)
def _along(matched, shifts):
    """Sums (P, 3 T) of N parts (N, P, T), each earlier by its shift, and how many there are (3 T,).

    Lines that begin up to a window before the first bin, or after the last, may enter later.
    """
    parts, zones, bins = matched.shape
    along, passed = np.zeros((zones, 3 * bins)), np.zeros(3 * bins)
    for part in range(parts):
        first = bins - shifts[part]
        passed[first : first + bins] += 1
        for p in range(zones):
            for t in range(bins):
                along[p, first + t] += matched[part, p, t]
    return along, passed

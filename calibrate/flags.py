"""Which samples of a scan are saturated or suspicious, and why."""

from enum import IntFlag

import numpy as np

from calibrate.responses import Responses
from calibrate.window import Window

CLIPPED_SEEN = 3  # cells at exactly the largest count before it is called a limit of the counter
CLIPPED_LEAST = 255  # below, equal counts are no surprise
PILE_UP = 0.05  # events per laser shot and frame from which the first photon hides later ones (effects: pile_up)
BRIGHTER = 5.0  # standard errors by which the background may exceed the patch's capture


class Flag(IntFlag):
    """Bits of `ResponseMaps.flags`."""

    SATURATED = 1  # the counter clipped: the true response is higher
    PILE_UP = 2  # more than 5 % events per laser shot: the true response is higher
    WINDOW_EDGE = 4  # the maximum lies on the first or last bin of the window: the pulse may be cut
    NO_SIGNAL = 8  # not above what noise alone reaches
    BACKGROUND_BRIGHTER = 16  # the capture without patch holds more light: something moved between the scans
    OUTLIER = 32  # departs from what all other samples predict: a damaged histogram, a wrong patch centre
    PREDICTED = 64  # not measured: the scan did not go there


def flag_samples(
    counts: np.ndarray,
    background: np.ndarray | None,
    laser_cycles: np.ndarray | None,
    frames: np.ndarray,
    window: Window,
    found: Responses,
    outliers: np.ndarray,
) -> np.ndarray:
    """(P, K) bits of `Flag` for every sample.

    counts, background: (F, P, T); laser_cycles: () or (F,) shots per frame, None where unknown; frames: (K, repeats)
    of each position; outliers: (P, K) from the kernel.
    """
    flags = np.zeros(found.value.shape, np.uint8)

    def mark(flag: Flag, where: np.ndarray) -> None:
        flags[where] |= np.uint8(flag)

    by_frame = {Flag.SATURATED: clipped(counts, window)}
    if laser_cycles is not None:
        shots = np.broadcast_to(np.asarray(laser_cycles, float), len(counts))
        by_frame[Flag.PILE_UP] = counts.sum(axis=2, dtype=float) > PILE_UP * shots[:, None]
    for flag, hit in by_frame.items():
        mark(flag, hit[frames].any(axis=1).T)

    no_signal = found.value <= found.noise_limit
    mark(Flag.NO_SIGNAL, no_signal)
    edge = (found.peak_bin == window.first) | (found.peak_bin == window.last)
    mark(Flag.WINDOW_EDGE, edge & ~no_signal)
    if background is not None:
        mark(Flag.BACKGROUND_BRIGHTER, _background_brighter(counts, background, frames, window))
    mark(Flag.OUTLIER, outliers)
    return flags


def clipped(counts: np.ndarray, window: Window) -> np.ndarray:
    """(F, P) histograms with a bin at the limit of the counter, inside the window.

    The limit is not recorded. Photon counts of a thousand or more hardly ever repeat their very largest value, so one
    that several cells share is a limit.
    """
    inside = counts[:, :, window.first : window.last + 1]
    largest = inside.max()
    at_largest = inside == largest
    if largest < CLIPPED_LEAST or at_largest.sum() < CLIPPED_SEEN:
        return np.zeros(counts.shape[:2], bool)
    return at_largest.any(axis=2)


def _background_brighter(counts: np.ndarray, background: np.ndarray, frames: np.ndarray, window: Window) -> np.ndarray:
    """(P, K) positions at which some bin of the window lost light significantly when the patch was there."""
    lit, dark = (
        c[:, :, window.first : window.last + 1][frames.ravel()]
        .astype(float)
        .reshape(*frames.shape, c.shape[1], -1)
        .sum(1)
        for c in (counts, background)
    )
    deficit = (dark - lit) / np.sqrt(np.maximum(dark + lit, 1))
    # A drift of the laser shows as a deficit in proportion to the light; 2 % is not suspicious.
    return ((deficit > BRIGHTER) & (dark - lit > 0.02 * dark)).any(axis=2).T


def describe(flags: np.ndarray) -> dict[str, int]:
    """How many samples carry each flag, by name; flags that none carries are left out."""
    counted = {flag.name.lower(): int(np.count_nonzero(flags & flag)) for flag in Flag}
    return {name: count for name, count in counted.items() if count}

"""The window of bins G in which the patch's pulse is looked for, chosen from the data."""

from dataclasses import dataclass

import numpy as np

from recordings.refusal import Refusal

SIGNIFICANT = 6.0  # standard deviations before a peak counts as seen
GAIN_NOISE = 0.01  # relative drift allowed between the two scans before a difference counts as light of the patch
GAP_BINS = 1  # peaks further apart than this belong to different surfaces
MARGIN_BINS = 2  # so that a pulse at the edge of the cluster is not cut
KEPT = 0.999  # share of a cluster's peaks that the window keeps; the rest are chance maxima far out


@dataclass(frozen=True)
class Window:
    """Bins `first` to `last`, both included, that hold the patch's pulse.

    share: fraction of all significant peaks that fall inside. others: bin ranges of peaks elsewhere, strongest first
    (the arm, a wall that moved, drifting crosstalk), each with its share. chosen: "data" or "user".
    """

    first: int
    last: int
    share: float = 1.0
    others: tuple[tuple[int, int, float], ...] = ()
    chosen: str = "user"

    def __len__(self) -> int:
        return self.last - self.first + 1

    @staticmethod
    def checked(first: int, last: int, bins: int) -> "Window":
        """A window given by the user; refused where it lies outside the `bins` of the histograms."""
        if not 0 <= first <= last < bins:
            raise Refusal(f"window: {first}:{last} found, expected first:last with 0 <= first <= last < {bins} bins")
        return Window(first, last)


def choose_window(counts: np.ndarray, background: np.ndarray | None) -> Window:
    """Choose G: the cluster of bins that holds most of the light that is there only with the patch.

    counts, background: (F, P, T) photon counts with and without the patch. Without a background scan each zone's
    median histogram over the scan stands in for it, since a zone sees the patch in a minority of the positions.
    Raises `Refusal` where no capture shows light of the patch.
    """
    peak, height = _significant_peaks(counts, background)
    if len(peak) == 0:
        raise Refusal("counts: no capture shows more light with the patch than without, expected a patch scan")
    bins = counts.shape[2]
    seen = np.bincount(peak, minlength=bins)
    light = np.bincount(peak, weights=height, minlength=bins)

    clusters = _clusters(np.flatnonzero(seen))
    clusters.sort(key=lambda c: -light[c[0] : c[1] + 1].sum())
    first, last = _trimmed(light, seen, *clusters[0])
    return Window(
        first=max(first - MARGIN_BINS, 0),
        last=min(last + MARGIN_BINS, bins - 1),
        share=float(seen[first : last + 1].sum() / seen.sum()),
        others=tuple((a, b, float(seen[a : b + 1].sum() / seen.sum())) for a, b in clusters[1:]),
        chosen="data",
    )


def _significant_peaks(counts: np.ndarray, background: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
    """Bin and height of the largest difference of each capture and zone, where it stands out of the noise."""
    stood_in = background is None
    dark = np.median(counts, axis=0, keepdims=True) if stood_in else background
    peaks, heights = [], []
    # Zone by zone bounds the memory: (F, T) at a time.
    for p in range(counts.shape[1]):
        with_patch = counts[:, p].astype(np.float64)
        without = np.broadcast_to(dark[:, p].astype(np.float64), with_patch.shape)
        difference = with_patch - without
        noise = np.sqrt(with_patch + without * (not stood_in) + (GAIN_NOISE * without) ** 2 + 1)
        peak = difference.argmax(axis=1)
        rows = np.arange(len(peak))
        height = difference[rows, peak]
        significant = height > SIGNIFICANT * noise[rows, peak]
        peaks.append(peak[significant])
        heights.append(height[significant])
    return np.concatenate(peaks), np.concatenate(heights)


def _clusters(bins: np.ndarray) -> list[tuple[int, int]]:
    """Runs of bins no further than the gap apart, as (first, last)."""
    runs = np.split(bins, np.flatnonzero(np.diff(bins) > GAP_BINS + 1) + 1)
    return [(int(run[0]), int(run[-1])) for run in runs]


def _trimmed(light: np.ndarray, seen: np.ndarray, first: int, last: int) -> tuple[int, int]:
    """Narrow a cluster from both sides while it keeps nearly all of its peaks, by count and by light."""
    keep = []
    for weight in (light, seen):
        share = np.cumsum(weight[first : last + 1]) / weight[first : last + 1].sum()
        keep.append((np.searchsorted(share, 1 - KEPT), np.searchsorted(share, KEPT)))
    return first + int(min(k[0] for k in keep)), first + int(max(k[1] for k in keep))

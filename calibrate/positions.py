"""Which captures of a scan become samples of the maps, and where they lie in the image."""

from collections import Counter
from dataclasses import dataclass

import numpy as np

from calibrate.patch_track import PatchTrack
from calibrate.plan import ScanPlan
from recordings.refusal import Refusal

LEAST = 3  # positions without which there is no map
EXACT_PX = 1e-3  # centres are never better known than this


@dataclass(frozen=True, eq=False)
class Positions:
    """K positions of the patch that were seen.

    x_px, y_px, sigma_px: (K,) centre in the full-size image and its standard error. confidence: (K,) 0 to 1, the
    lowest of the repeats. frames: (K, repeats) indices of
    the captures. radius_px: of the patch. left_out: ids of the captures that
    gave no sample because no patch was seen.
    methods: how many frames were found in which way.
    """

    x_px: np.ndarray
    y_px: np.ndarray
    sigma_px: np.ndarray
    confidence: np.ndarray
    frames: np.ndarray
    radius_px: float
    left_out: list[str]
    methods: dict[str, int]


def scan_positions(track: PatchTrack, plan: ScanPlan | None) -> Positions:
    """Average the patch's centre over the repeats of each position; one not seen in every repeat is left out.

    Raises `Refusal` where fewer than three positions were seen.
    """
    frames = np.arange(len(track.x_px))[:, None] if plan is None else plan.frames
    kept = track.found[frames].all(axis=1)
    if kept.sum() < LEAST:
        raise Refusal(f"rgb: the patch was seen at {kept.sum()} of {len(frames)} positions, expected at least {LEAST}")
    inside = frames[kept]
    # Repeats are weighted by their errors; an error of 0 stands for positions that were given as exact.
    weight = 1 / np.maximum(track.sigma_px[inside], EXACT_PX) ** 2
    total = weight.sum(axis=1)
    return Positions(
        x_px=(weight * track.x_px[inside]).sum(axis=1) / total,
        y_px=(weight * track.y_px[inside]).sum(axis=1) / total,
        sigma_px=1 / np.sqrt(total),
        confidence=track.confidence[inside].min(axis=1),
        frames=inside,
        radius_px=float(np.median(track.radius_px[inside])),
        left_out=[f"{frame:04d}" for frame in frames[~kept].ravel()],
        methods=dict(Counter(track.method[frames.ravel()].tolist())),
    )

"""The patch in frames that belong to no grid: near where it was last, or anywhere."""

from collections.abc import Sequence

import numpy as np

from calibrate.patch_edge import Disc
from calibrate.patch_find import find_discs
from calibrate.patch_frames import GreyFrames
from calibrate.patch_sample import stands_still
from calibrate.patch_target import Target, locate
from recordings.progress import Progress

REACH = 2.0  # Radii by which the patch may have moved since the last frame, beyond its last step.


def follow(
    frames: GreyFrames, indices: Sequence[int], target: Target, still: np.ndarray, progress: Progress
) -> dict[int, Disc]:
    """The patch by frame number, of those `indices`, in order of time, in which it is seen.

    Looked for around its last place; where it is not there, in the whole image. A disc like it at one of the places
    `still` (n, 2) is something else.
    """
    found: dict[int, Disc] = {}
    last: Disc | None = None
    step = 0.0
    reach = REACH * float(target.radius[0])
    for index, grey in frames.each(indices, lambda _, grey: grey, progress, "following the patch"):
        near = locate(grey, target, np.array([last.x_px, last.y_px]), reach + step) if last else None
        disc = _clear([near] if near else [], target, still)
        disc = disc or _clear(find_discs(grey, float(target.radius[0])), target, still)
        if disc is None:
            continue
        step = min(np.hypot(disc.x_px - last.x_px, disc.y_px - last.y_px), reach) if last else 0.0
        found[index] = last = disc
    return found


def _clear(discs: list[Disc], target: Target, still: np.ndarray) -> Disc | None:
    """The first of the discs that is the patch and moves."""
    return next((disc for disc in discs if target.is_clearly_shown_by(disc) and not stands_still(disc, still)), None)

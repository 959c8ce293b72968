"""The patch in frames that belong to no grid: near where it was last, or anywhere."""

from collections.abc import Sequence

import numpy as np

from calibrate.patch_edge import Disc
from calibrate.patch_frames import GreyFrames
from calibrate.patch_sample import stands_still
from calibrate.patch_target import CERTAIN, Target, locate, search
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
        disc = None
        if last:
            disc = locate(grey, target, np.array([last.x_px, last.y_px]), reach + step)
        if disc is None or disc.confidence < CERTAIN or stands_still(disc, still):
            disc = next((other for other in search(grey, target) if not stands_still(other, still)), None)
        if disc is None:
            continue
        step = min(np.hypot(disc.x_px - last.x_px, disc.y_px - last.y_px), reach) if last else 0.0
        found[index] = last = disc
    return found

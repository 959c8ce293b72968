"""The patch in every frame of a scan, without a click."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calibrate.patch_edge import Disc
from calibrate.patch_follow import follow
from calibrate.patch_frames import GreyFrames
from calibrate.patch_repair import expect
from calibrate.patch_sample import learn_grid, learn_target_alone
from calibrate.patch_target import locate
from calibrate.plan import ScanPlan
from recordings.progress import Progress, silent
from recordings.refusal import Refusal

# How far from the grid model the patch is looked for: standard deviations of what it was fitted to, within radii.
SIGMAS, MARGIN = 6.0, (0.75, 1.5)
LEAST_CELLS = 3
LEAST_SHARE = 0.01


@dataclass(frozen=True, eq=False)
class PatchTrack:
    """Where the patch is in each of F frames.

    x_px, y_px: (F,) centre, pixel centres at integers, NaN where it was not found. sigma_px: (F,) standard error of
    the centre along one axis. radius_px: (F,). confidence: (F,) 0 to 1, how much of the rim and the inside the image
    supports; 0 where not found. method: (F,) text, "found" at once, "repaired" (found where its neighbours in the
    grid said it must be), "given" (by the recording) or "none".
    """

    x_px: np.ndarray
    y_px: np.ndarray
    sigma_px: np.ndarray
    radius_px: np.ndarray
    confidence: np.ndarray
    method: np.ndarray

    @property
    def found(self) -> np.ndarray:
        """(F,) bool."""
        return self.method != "none"

    @staticmethod
    def given(centres_px: np.ndarray, radius_px: float) -> "PatchTrack":
        """Centres (F, 2) that the recording knows already, taken as exact; NaN where there is no patch."""
        known = np.isfinite(centres_px).all(axis=1)
        alike = np.where(known, 1.0, np.nan)
        return PatchTrack(
            x_px=centres_px[:, 0] * alike,
            y_px=centres_px[:, 1] * alike,
            sigma_px=0 * alike,
            radius_px=radius_px * alike,
            confidence=known.astype(float),
            method=np.where(known, "given", "none"),
        )


def find_patches(
    frames: Sequence[np.ndarray],
    plan: ScanPlan | None = None,
    *,
    radius_px: float | None = None,
    progress: Progress = silent,
) -> PatchTrack:
    """Find the centre of a bright round patch in frames (H, W, 3) uint8 RGB; a frame without one stays without.

    frames: decoded when indexed, from several threads; a method `grey(i)`, if there is one, must return frame i in
    grey (H, W) uint8 and is used instead. plan: which frames show which cell of the grid; without it the patch is
    followed from frame to frame. radius_px: of the patch's image, to 10 %; learnt from the frames where None.

    Raises `Refusal` for frames that are no colour images of one size, fewer frames than the plan needs, a grid
    that does not fit, and scans that hardly show the patch.
    """
    if radius_px is not None and not (np.isfinite(radius_px) and radius_px >= 2):
        raise Refusal(f"radius_px is {radius_px}, expected 2 pixels or more")
    grey = GreyFrames(frames)
    if plan is not None and len(frames) < plan.count:
        raise Refusal(f"rgb has {len(frames)} frames, expected {plan.count} as the scan plan says")
    repaired: dict[int, Disc] = {}
    if plan is not None and len(plan.cells) >= LEAST_CELLS:
        found, repaired = _on_grid(grey, plan, radius_px, progress)
    else:
        target, still = learn_target_alone(grey, radius_px, progress)
        found = follow(grey, range(len(frames)), target, still, progress)
    seen = len(found) + len(repaired)
    if seen < max(1, LEAST_SHARE * len(frames)):
        raise Refusal(f"rgb: the patch was seen in {seen} of {len(frames)} frames, expected it in most")
    return _track(len(frames), found, repaired)


def _on_grid(
    grey: GreyFrames, plan: ScanPlan, radius_px: float | None, progress: Progress
) -> tuple[dict[int, Disc], dict[int, Disc]]:
    """Discs by frame, found at once and found on a second look."""
    grid, target, still = learn_grid(grey, plan, radius_px, progress)
    radius = float(target.radius[0])
    margin = float(np.clip(SIGMAS * grid.scatter_px, MARGIN[0] * radius, MARGIN[1] * radius))
    model = grid.predict(plan.cells)
    cell = {int(frame): divmod(i, plan.repeats) for i, frame in enumerate(plan.frames.ravel())}

    def locate_all(indices: np.ndarray, at_px: np.ndarray, margin_px: float, label: str) -> dict[int, Disc]:
        """Discs by frame, each near its cell's place (K, 2)."""

        def work(frame: int, image: np.ndarray) -> Disc | None:
            return locate(image, target, at_px[cell[frame][0]], margin_px)

        return {frame: disc for frame, disc in grey.each(indices, work, progress, label) if disc}

    found = locate_all(plan.frames.ravel(), model, margin, "finding the patch")
    at = np.full((*plan.frames.shape, 2), np.nan)
    for frame, disc in found.items():
        at[cell[frame]] = disc.x_px, disc.y_px
    expected = expect(plan, model, at)
    again = plan.frames[np.isnan(at[..., 0]) | expected.departs(at)]
    repaired = locate_all(again, expected.at_px, expected.limit_px, "looking again")
    for frame in again:
        found.pop(int(frame), None)
    outside = np.setdiff1d(np.arange(len(grey)), plan.frames)
    return found | follow(grey, outside, target, still, progress), repaired


def _track(count: int, found: dict[int, Disc], repaired: dict[int, Disc]) -> PatchTrack:
    values = {name: np.full(count, np.nan) for name in ("x_px", "y_px", "sigma_px", "radius_px")}
    values["confidence"] = np.zeros(count)
    method = np.full(count, "none", dtype="<U8")
    for word, discs in (("found", found), ("repaired", repaired)):
        for frame, disc in discs.items():
            method[frame] = word
            for name, column in values.items():
                column[frame] = getattr(disc, name)
    return PatchTrack(**values, method=method)

"""A first look at a few frames of a scan: what the patch looks like, and where the grid lies in the image."""

from collections.abc import Sequence

import numpy as np

from calibrate.patch_edge import Disc
from calibrate.patch_find import find_discs
from calibrate.patch_frames import GreyFrames
from calibrate.patch_grid import SAME_RADIUS, GridModel, Sightings, fit_grid
from calibrate.patch_target import Target, learn_target
from calibrate.plan import ScanPlan
from calibrate.sparse import spread_order
from recordings.progress import Progress
from recordings.refusal import Refusal

SAMPLE, LARGE_SAMPLE = 36, 196
STILL_PX = 2.0
CERTAIN = 0.7
STILL_SHARE = 0.6
LABEL = "looking for the patch"
EXPECTED = "a round patch that is brighter than its surround"


def learn_grid(
    frames: GreyFrames, plan: ScanPlan, radius_px: float | None, progress: Progress
) -> tuple[GridModel, Target, np.ndarray]:
    """The grid in the image, the patch, and places (n, 2) of discs like it that stand still in most frames.

    Looks at cells spread over the grid, its corners included; at four times as many where these do not suffice.
    Raises `Refusal` where no grid of the plan explains what is seen.
    """
    for count in (SAMPLE, LARGE_SAMPLE):
        chosen = _spread(plan, count)
        seen, still = _moving(_look(frames, plan.frames[chosen, 0], radius_px, progress))
        fitted = _fit(plan, chosen, seen, frames.size)
        if fitted:
            break
    else:
        raise _no_grid(sum(map(bool, seen)), len(chosen), plan)
    if radius_px is None and len(fitted[1]) < len(chosen) / 2:
        # The search for one radius sees more than the search for any.
        radius_px = float(np.median([disc.radius_px for disc in fitted[1]]))
        seen, still = _moving(_look(frames, plan.frames[chosen, 0], radius_px, progress))
        fitted = _fit(plan, chosen, seen, frames.size) or fitted
    grid, patch = fitted
    return grid, learn_target(patch, frames.size), still


def learn_target_alone(frames: GreyFrames, radius_px: float | None, progress: Progress) -> tuple[Target, np.ndarray]:
    """The patch, and places of discs like it that stand still, from frames whose order says nothing.

    The patch is the kind of disc, by radius, that is seen most often and most certainly, those that stand still
    in most frames left out unless nothing else is seen. Raises `Refusal` where no disc is seen.
    """
    count = len(frames)
    chosen = np.unique(np.linspace(0, count - 1, min(count, SAMPLE)).round().astype(int))
    moving, still = _moving(_look(frames, chosen, radius_px, progress))
    best: list[Disc] = []
    for kind in (disc for discs in moving for disc in discs):
        alike = [[disc for disc in discs if _alike(disc, kind)][:1] for discs in moving]
        members = [disc for discs in alike for disc in discs]
        if sum(disc.confidence for disc in members) > sum(disc.confidence for disc in best):
            best = members
    if not best:
        raise Refusal(f"rgb: none of {len(chosen)} frames looked at shows {EXPECTED}")
    return learn_target(best, frames.size), still


def stands_still(disc: Disc, still: np.ndarray) -> bool:
    """Whether a disc is at one of the places (n, 2) where something stands still."""
    return bool((np.hypot(*(still - (disc.x_px, disc.y_px)).T) < STILL_PX).any())


def _look(frames: GreyFrames, indices: Sequence[int], radius_px: float | None, progress: Progress) -> list[list[Disc]]:
    """Discs in each of some frames, without those that are not whole or even: one learns from the clear ones."""
    found = frames.each(indices, lambda _, grey: find_discs(grey, radius_px), progress, LABEL)
    return [[disc for disc in discs if disc.confidence > CERTAIN] for _, discs in found]


def _fit(
    plan: ScanPlan, chosen: np.ndarray, seen: list[list[Disc]], size: tuple[int, int]
) -> tuple[GridModel, list[Disc]] | None:
    """The grid that explains the discs seen at some cells, and those that are the patch."""
    discs = [disc for found in seen for disc in found]
    sightings = Sightings(
        cell=plan.cells[np.repeat(chosen, [len(found) for found in seen])],
        at_px=np.array([(disc.x_px, disc.y_px) for disc in discs]).reshape(-1, 2),
        radius_px=np.array([disc.radius_px for disc in discs]),
        confidence=np.array([disc.confidence for disc in discs]),
    )
    # The seed is fixed, so that a scan always gives the same centres.
    fitted = fit_grid(sightings, len(chosen), (plan.columns, plan.rows), size, np.random.default_rng(0))
    return fitted and (fitted[0], [disc for disc, belongs in zip(discs, fitted[1], strict=True) if belongs])


def _no_grid(shown: int, count: int, plan: ScanPlan) -> Refusal:
    if shown < count / 4:
        return Refusal(f"rgb: {shown} of {count} frames looked at show {EXPECTED}, expected one in most")
    return Refusal(
        f"rgb: the discs seen in {shown} of {count} frames looked at do not follow a grid of {plan.columns} x "
        f"{plan.rows} cells in {plan.order} order, expected the grid of the scan plan"
    )


def _spread(plan: ScanPlan, count: int) -> np.ndarray:
    """Indices of about `count` cells spread over the grid, its corners included."""
    if plan.listed:
        return np.sort(spread_order(plan.cells, min(count, len(plan.cells))))
    rows = min(plan.rows, int(count**0.5))
    columns = min(plan.columns, count // rows)
    rows = min(plan.rows, count // columns)
    chosen = [
        np.isin(plan.cells[:, axis], np.linspace(0, side - 1, number).round())
        for axis, side, number in ((0, plan.columns, columns), (1, plan.rows, rows))
    ]
    return np.flatnonzero(chosen[0] & chosen[1])


def _alike(one: Disc, other: Disc) -> bool:
    return abs(np.log(one.radius_px / other.radius_px)) < SAME_RADIUS


def _moving(seen: list[list[Disc]]) -> tuple[list[list[Disc]], np.ndarray]:
    """Discs without those at places that show one in most frames, and these places (n, 2).

    Where little else is seen, the patch itself may be at rest: then everything is kept.
    """
    owner = np.repeat(np.arange(len(seen)), [len(discs) for discs in seen])
    at = np.array([(disc.x_px, disc.y_px) for discs in seen for disc in discs]).reshape(-1, 2)
    here = np.linalg.norm(at[:, None] - at, axis=-1) < STILL_PX
    often = [len(np.unique(owner[row])) >= max(3, STILL_SHARE * len(seen)) for row in here]
    still = np.unique(at[np.array(often, bool)].round(), axis=0)
    moving = [[disc for disc in discs if not stands_still(disc, still)] for discs in seen]
    if sum(map(bool, moving)) < sum(map(bool, seen)) / 2:
        return seen, np.empty((0, 2))
    return moving, still

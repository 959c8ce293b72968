"""Maps of a scan that left positions of its grid out, completed by what these would have measured."""

import numpy as np

from calibrate.adaptive_fill import LEAST, filled
from calibrate.patch_grid import Sightings, fit_grid
from calibrate.plan import ScanPlan
from calibrate.positions import Positions
from recordings.maps import ResponseMaps


def left_out(plan: ScanPlan | None) -> int:
    """How many positions of the plan's grid were not visited on purpose."""
    return plan.columns * plan.rows - plan.visits if plan is not None and plan.listed else 0


def completed(maps: ResponseMaps, plan: ScanPlan, positions: Positions) -> ResponseMaps:
    """Maps at all positions of the grid, predicted where the scan did not go; as they are where that cannot be.

    It can where 40 positions or more were seen, they follow the grid of the plan, and the SPADs of the zones are known.
    """
    if len(maps.xs) < LEAST:
        return maps
    centres = grid_centres(plan, positions, maps.image_size)
    return maps if centres is None else filled(maps, centres, positions.radius_px)


def grid_centres(plan: ScanPlan, positions: Positions, size: tuple[int, int]) -> np.ndarray | None:
    """(columns · rows, 2) pixels of every cell, row by row, from those that were seen; None where they fit no grid."""
    visit = np.searchsorted(plan.frames[:, 0], positions.frames[:, 0])
    seen = Sightings(
        cell=plan.cells[visit],
        at_px=np.stack([positions.x_px, positions.y_px], axis=1),
        radius_px=np.full(len(visit), positions.radius_px),
        confidence=np.maximum(positions.confidence, 1e-3),
    )
    fitted = fit_grid(seen, len(visit), (plan.columns, plan.rows), size, np.random.default_rng(0))
    if fitted is None:
        return None
    row, column = np.divmod(np.arange(plan.columns * plan.rows), plan.columns)
    return fitted[0].predict(np.stack([column, row], axis=1))

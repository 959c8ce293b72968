"""Where in the image the patch is at every position of the grid, from a few positions seen before the scan."""

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import cv2
import numpy as np

from calibrate.patch_edge import Disc
from calibrate.patch_frames import GreyFrames
from calibrate.patch_grid import GridModel
from calibrate.patch_sample import learn_grid
from calibrate.patch_target import Target, locate
from calibrate.plan import ScanPlan
from devices.scan.motion_plan import MotionPlan
from recordings.progress import silent
from recordings.refusal import Refusal

# So many columns and rows are looked at: enough to tell how the patch's radius varies over the image.
SIDE = 4
# The arm is more exact than this, the lens less: so far from where the survey expects it the patch is looked for.
MARGIN_RADII = 0.75
# Beyond this the patch's plane is not what a calibration takes it for.
MOST_TILT_DEG = 3.0


@dataclass(frozen=True, eq=False)
class Survey:
    """The grid and the patch as the camera sees them.

    grid: from cells to pixels. target: what the patch looks like.
    """

    grid: GridModel
    target: Target

    def expected_px(self, cells: np.ndarray) -> np.ndarray:
        """(K, 2) pixels at which the patch is expected at cells (K,), numbered row · columns + column."""
        row, column = np.divmod(np.asarray(cells), self.grid.shape[0])
        return self.grid.predict(np.stack([column, row], axis=-1))

    def find(self, rgb: np.ndarray, cell: int) -> Disc | None:
        """The patch in a picture (H, W, 3) uint8 near where it is expected, None where it is not."""
        grey = cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY)
        at = self.expected_px(np.array([cell]))[0]
        return locate(grey, self.target, at, MARGIN_RADII * self.target.radius_px(*at))

    def tilt_deg(self, focal_px: float) -> float:
        """By how much the patch's plane is turned against the image's.

        The radius is inverse to depth z; over a width W of the image, W z / f metres, it changes by Δr, so
        tan(tilt) = (Δr / r) f / W.
        """
        radius, *slope = self.target.radius
        return float(np.degrees(np.arctan(np.hypot(*slope) / radius * focal_px / self.target.size[0])))

    def to_json(self) -> dict[str, Any]:
        """For the journal."""
        return {
            "grid": asdict(self.grid) | {"parameters": self.grid.parameters.tolist()},
            "target": asdict(self.target) | {"radius": self.target.radius.tolist()},
        }

    @staticmethod
    def from_json(said: dict[str, Any]) -> "Survey":
        """What `to_json` made."""
        grid, target = dict(said["grid"]), dict(said["target"])
        grid |= {name: tuple(grid[name]) for name in ("shape", "size")} | {"parameters": np.array(grid["parameters"])}
        target |= {"size": tuple(target["size"]), "radius": np.array(target["radius"])}
        return Survey(GridModel(**grid), Target(**target))


def survey(plan: MotionPlan, look: Callable[[int], np.ndarray]) -> Survey:
    """Look at a few cells, spread over the grid and its corners, and learn where the others are.

    look: moves the arm to a cell and returns the picture (H, W, 3) uint8. Raises `Refusal` where the patch is not seen
    or does not follow the arm.
    """
    columns = np.unique(np.linspace(0, plan.columns - 1, SIDE).round().astype(int))
    rows = np.unique(np.linspace(0, plan.rows - 1, SIDE).round().astype(int))
    cells = (rows[:, None] * plan.columns + columns).ravel().tolist()
    pictures = GreyFrames([look(cell) for cell in cells])
    seen = ScanPlan(plan.columns, plan.rows, order="listed", listed=cells)
    try:
        grid, target, _ = learn_grid(pictures, seen, None, silent)
    except Refusal as unseen:
        raise Refusal(
            f"before the scan, {unseen}; see that the patch is on its holder, that the camera sees it at all three "
            "corners of the plan, and that nothing as bright and round is in view"
        ) from None
    return Survey(grid, target)

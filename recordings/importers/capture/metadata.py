"""What the first record of a published capture says of the scan: grid, range mode, camera."""

from typing import Any

import numpy as np

from recordings.importers.capture.record import MOST_ITERATIONS, is_number, whole
from recordings.importers.inert.walk import named

# Published capture script's grid where its file does not say: 80 positions a row, 45 rows.
DEFAULT_GRID = (80, 45)
# Width of a bin and arrival bin at range 0, the mean over the nine channels of a factory calibration page.
BIN_WIDTH_S = {"LONG": 0.38e-9, "SHORT": 92.5e-12}
TIME_ZERO_BINS = {"LONG": 15.32, "SHORT": 14.21}
# Robots report positions to about this.
SAME_PLACE_M = 1e-6


def range_mode(metadata: dict[str, Any]) -> str | None:
    """LONG or SHORT as the capture script noted it; None where it did not."""
    said = named(metadata.get("range_mode", metadata.get("spad_range"))).rpartition(".")[2].upper()
    return said if said in BIN_WIDTH_S else None


def scan_plan(metadata: dict[str, Any], iterations: list[int]) -> dict[str, Any] | None:
    """The grid that rising `iterations` ran over, as a recording's metadata carry it; None where it is not known.

    Iteration 0 is taken before the arm moves; then `repeats` at each of columns x rows positions, row 0 lowest, every
    other row backwards. `lost` lists the iterations that are not there.
    """
    points = metadata.get("robot_grid_points")
    said = {named(name).lower(): value for name, value in metadata.items()}
    repeats = whole(said.get("repeats_per_point", 1)) or 1
    last, there = iterations[-1], set(iterations)
    if isinstance(points, np.ndarray):
        grid = snake(points)
    elif "y_steps" in said and "z_steps" in said:
        grid = whole(said["y_steps"]), whole(said["z_steps"])
    else:
        grid = DEFAULT_GRID if last == DEFAULT_GRID[0] * DEFAULT_GRID[1] * repeats else None
    if grid is None or not all(grid) or len(there) < len(iterations):
        return None
    steps = grid[0] * grid[1] * repeats
    # Where the capture before the arm moves failed, the scripts number the grid from 0: a scan that ends one short
    # may be that, or may have lost its last record.
    if steps >= MOST_ITERATIONS or last > steps or last == steps - 1:
        return None
    lost = [i for i in range(1 + steps) if i not in there]
    return {"columns": grid[0], "rows": grid[1], "order": "snake", "first": 1, "repeats": repeats, "lost": lost}


def snake(points: np.ndarray) -> tuple[int, int] | None:
    """Columns and rows of (N, 3) positions that run along y, back and forth, a row for each z."""
    if points.ndim != 2 or points.shape[1] != 3 or points.dtype.kind != "f" or not len(points):
        return None
    turns = np.flatnonzero(np.abs(np.diff(points[:, 2])) > SAME_PLACE_M)
    columns = int(turns[0]) + 1 if len(turns) else len(points)
    if len(points) % columns:
        return None
    rows = points.reshape(-1, columns, 3)
    along = rows[:, :, 1].copy()
    along[1::2] = along[1::2, ::-1]
    level = np.ptp(rows[:, :, 2], axis=1).max() <= SAME_PLACE_M
    return (columns, len(rows)) if level and np.ptp(along, axis=0).max() <= SAME_PLACE_M else None


def pinhole(metadata: dict[str, Any], height: int, width: int) -> np.ndarray | None:
    """(3, 3) matrix of the colour camera, to which depth is aligned; None where it is not given."""
    config = metadata.get("realsense_config")
    if isinstance(config, dict):
        size = config.get("color_width", width), config.get("color_height", height)
        if size != (width, height):
            return None
    said = metadata.get("realsense_intrinsics")
    if isinstance(said, dict):
        said = said.get("color", said)
    if not isinstance(said, dict) or not all(is_number(said.get(n)) for n in ("fx", "fy", "ppx", "ppy")):
        return None
    if min(said["fx"], said["fy"]) <= 0:
        return None
    return np.array([[said["fx"], 0, said["ppx"]], [0, said["fy"], said["ppy"]], [0, 0, 1]], float)

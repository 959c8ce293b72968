"""The TMF882x's SPAD array and how its zones share it out (datasheet DS000693 v8)."""

from dataclasses import dataclass

import numpy as np

from recordings.refusal import Refusal

# Usable array, pitch of the SPADs, distance of the lens. One SPAD sees 2.4 × 5.6 degrees.
COLUMNS, ROWS = 18, 12
PITCH_X_M, PITCH_Y_M = 16.8e-6, 38.8e-6
FOCAL_M = 400e-6

# Columns and rows of SPADs per column and row of zones, by spad_map_id; each map is centred in the array.
BLOCKS = {
    1: ((5, 4, 5), (2, 2, 2)),
    7: ((5, 4, 4, 5), (3, 2, 2, 3)),
    10: ((5, 4, 5), (2, 2, 2, 2, 2, 2)),
    13: ((4, 3, 3, 4), (2, 2, 2, 2)),
}

# Map 6, 3 × 3 wide, Figure 30: rows 2 to 11; in the combs of rows 5 and 8 neighbouring zones interleave.
WIDE_3X3 = """
111111222222333333
111111222222333333
111111222222333333
414141525525363636
444444555555666666
444444555555666666
474747585585969696
777777888888999999
777777888888999999
777777888888999999
"""


@dataclass(frozen=True, eq=False)
class SpadMap:
    """Which SPADs each zone sums, and where they look.

    masks: (P, 12, 18) bool, zones row-major; row 0 looks up, column 0 looks to the right of the camera's
    image.
    zone_grid: rows and columns of zones.
    tan_x: (18,), tan_y: (12,) tangents of the SPAD centres' directions, x to the right and y down as in the
    image.
    """

    masks: np.ndarray
    zone_grid: tuple[int, int]

    @property
    def tan_x(self) -> np.ndarray:
        """Descending: the sensor's columns, counted in its top view, are mirrored in what it looks at."""
        return -(np.arange(COLUMNS) - (COLUMNS - 1) / 2) * PITCH_X_M / FOCAL_M

    @property
    def tan_y(self) -> np.ndarray:
        """Ascending: row 0 looks up."""
        return (np.arange(ROWS) - (ROWS - 1) / 2) * PITCH_Y_M / FOCAL_M


def spad_map(spad_map_id: int) -> SpadMap:
    """The SPAD map with this id of the TMF882x; refuses ids whose layout is not in the tables above."""
    if spad_map_id == 6:
        zone = np.array([[int(digit) for digit in row] for row in WIDE_3X3.split()])
        grid = (3, 3)
    elif spad_map_id in BLOCKS:
        columns, rows = BLOCKS[spad_map_id]
        row, column = np.repeat(np.arange(len(rows)), rows), np.repeat(np.arange(len(columns)), columns)
        zone = 1 + row[:, None] * len(columns) + column
        grid = (len(rows), len(columns))
    else:
        known = ", ".join(str(known) for known in sorted([6, *BLOCKS]))
        raise Refusal(f"spad_map_id is {spad_map_id!r}, expected one of {known}")
    above, left = (ROWS - zone.shape[0]) // 2, (COLUMNS - zone.shape[1]) // 2
    placed = np.zeros((ROWS, COLUMNS), int)
    placed[above : above + zone.shape[0], left : left + zone.shape[1]] = zone
    return SpadMap(placed == np.arange(1, zone.max() + 1)[:, None, None], grid)

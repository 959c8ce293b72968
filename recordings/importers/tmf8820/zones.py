"""The zone table beside a TMF8820 recording: where each zone looks, as a rectangle of angles."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from recordings.importers.tmf8820.frames import read_json
from recordings.refusal import Refusal

NAME = "zone_spec.json"


@dataclass(frozen=True, eq=False)
class Zones:
    """Rectangles of P zones in the sensor's frame (z forward), in the sensor's own order.

    low, high: (P, 2) tangent of the angles to x and y at the rectangle's edges. The photodiodes lie in a
    plane behind a lens, so a zone is a rectangle in tangents. grid: rows, columns; the order is row-major.
    """

    low: np.ndarray
    high: np.ndarray
    grid: tuple[int, int]


def read_zones(recording: Path, zones: Path | None = None) -> Zones:
    """The table `zones`, or `zone_spec.json` beside a recording: `center` (x, y), `width`, `height`, radians."""
    path = recording.parent / NAME if zones is None else zones
    if not path.is_file():
        raise Refusal(f"{path} is missing, expected the zone table beside the recording")
    table = read_json(path)
    if not isinstance(table, list) or not table:
        raise Refusal(f"{path}: is not a list of zones, expected center, width and height of each")
    rows = []
    for zone, entry in enumerate(table):
        try:
            x, y = entry["center"]
            row = [float(value) for value in (x, y, entry["width"], entry["height"])]
        except (TypeError, ValueError, KeyError, OverflowError):
            raise Refusal(f"{path}: zone {zone} lacks center (x, y), width or height in radians") from None
        if not (np.isfinite(row).all() and min(row[2:]) > 0):
            raise Refusal(f"{path}: zone {zone} is {row}, expected finite angles and a positive width and height")
        rows.append(row)
    centre, size = np.hsplit(np.array(rows), 2)
    low, high = centre - size / 2, centre + size / 2
    if np.abs((low, high)).max() >= np.pi / 2:
        raise Refusal(f"{path}: a zone reaches 90 degrees, expected angles in radians from the optical axis")
    # Down in y first, then the next x: the distinct x are the rows of the sensor's own order.
    grid = len(np.unique(centre[:, 0].round(6))), len(np.unique(centre[:, 1].round(6)))
    if grid[0] * grid[1] != len(rows):
        raise Refusal(f"{path}: {len(rows)} zones lie at {grid[0]} x and {grid[1]} y, expected a full grid")
    return Zones(np.tan(low), np.tan(high), grid)

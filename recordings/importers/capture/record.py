"""What one record of a published capture holds: its number, histogram, colour and depth."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from recordings.importers.inert.makers import StandIn
from recordings.importers.inert.stored_array import StoredArray
from recordings.importers.inert.walk import arrays_in
from recordings.refusal import Refusal

# Zones a sensor of this family has where a record gives them in one row: 3 x 3, 4 x 4, 8 x 8.
SQUARE_GRIDS = {9: 3, 16: 4, 64: 8}
ENUM = "SPADDataType"
# More than any scan; what it bounds is the list of those missing.
MOST_ITERATIONS = 1_000_000
# The value the publisher's enum gives its member HISTOGRAM.
HISTOGRAM_VALUES = ("HISTOGRAM", 1)
TIMES = ("timestamp_s", "timestamp")


@dataclass(frozen=True)
class Capture:
    """A record of the stream: `histogram` (rows, cols, T) or (P, T), `colour` (H, W, 3) bgr8, `depth` (H, W).

    `number` counts the records of the stream, `iteration` is what the script counted. Depth in millimetres.
    `unused` names the arrays that a recording has no place for.
    """

    number: int
    iteration: int | None
    time_s: float | None
    histogram: StoredArray
    colour: StoredArray | None
    depth: StoredArray | None
    unused: tuple[str, ...]

    @property
    def zone_grid(self) -> tuple[int, int]:
        """Rows and columns of the zones."""
        if len(self.histogram.shape) == 3:
            return self.histogram.shape[:2]
        side = SQUARE_GRIDS[self.histogram.shape[0]]
        return side, side

    @property
    def layout(self) -> tuple[tuple[str, str], ...]:
        """What must be alike in all captures of a recording: what it is, and how it is here."""
        arrays = {"histogram": self.histogram, "colour": self.colour, "depth": self.depth}
        shapes = ((name, f"{array.shape} {array.dtype.name}" if array else "none") for name, array in arrays.items())
        return (*shapes, ("time", "none" if self.time_s is None else "seconds"))


def capture(number: int, record: Any) -> Capture:
    """The capture in a revived record; `Refusal` says what of it is missing."""
    if not isinstance(record, dict):
        raise Refusal(f"holds {type(record).__name__}, expected a dictionary")
    histograms = [item for key, item in record.items() if is_histogram(key) and isinstance(item, StoredArray)]
    if not histograms:
        raise Refusal("has no histogram")
    histogram = histograms[0]
    shape = histogram.shape
    if 0 in shape or not (len(shape) == 3 or (len(shape) == 2 and shape[0] in SQUARE_GRIDS)):
        raise Refusal(f"has a histogram of shape {shape}, expected rows, columns and bins")
    if histogram.dtype.kind not in "ui":
        raise Refusal(f"has a histogram of {histogram.dtype.name}, expected integers")
    images = {name: array for name, array in arrays_in(record) if "tracking" not in name}
    colour = preferred(images, lambda a: a.dtype == np.uint8 and len(a.shape) == 3 and a.shape[2] == 3)
    size = colour and images[colour].shape[:2]
    depth = preferred(images, lambda a: a.dtype == np.uint16 and len(a.shape) == 2 and size in (None, a.shape))
    used = (colour, depth)
    return Capture(
        number=number,
        iteration=whole(record.get("iter")),
        time_s=next((float(record[k]) for k in TIMES if is_number(record.get(k))), None),
        histogram=histogram,
        colour=images[colour] if colour else None,
        depth=images[depth] if depth else None,
        unused=tuple(n for n, a in arrays_in(record) if n not in used and a is not histogram),
    )


def is_histogram(key: Any) -> bool:
    """Whether a record's key is the publisher's enum member HISTOGRAM, or says so in words."""
    if isinstance(key, StandIn):
        return key.name.endswith(ENUM) and key.args[:1] and key.args[0] in HISTOGRAM_VALUES
    return isinstance(key, str) and key.lower() == "histogram"


def preferred(arrays: dict[str, StoredArray], fits: Callable[[StoredArray], bool]) -> str | None:
    """Name of the array that fits: one aligned to colour if there is one, else the first not called raw."""
    names = [name for name, array in arrays.items() if 0 not in array.shape and fits(array)]
    return min(names, key=lambda name: ("aligned" not in name, "raw" in name), default=None)


def is_number(value: Any) -> bool:
    """Whether `value` is a finite number."""
    return (type(value) is int and value.bit_length() < 64) or (type(value) is float and math.isfinite(value))


def whole(value: Any) -> int | None:
    """`value` where it counts something."""
    return value if type(value) is int and 0 <= value < MOST_ITERATIONS else None

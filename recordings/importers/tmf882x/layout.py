"""How the lines of a measurement become zones, in each mode of the TMF882x.

A set is 30 lines: 3 planes of 10 channels, channel 0 of the reference. The chip has 9 channels for zones, so modes of
more zones take several sets. 4x4 and 3x6 take two, one after another, then comes one result line for both; 8x8 takes
two for each of four sub-captures, each with a result line, in whose number the lowest two bits say which sub-capture
it was. Datasheet DS000693: zones are numbered row by row, 3x6 being 3 columns of 6 rows; 4x4 leaves channel 9 unused.
"""

from dataclasses import dataclass

import numpy as np

# Zone of each channel 1 to 8 of the two sets of sub-capture 0, and what the other sub-captures add: the makers' table.
EIGHT_BY_EIGHT = ((56, 60, 40, 44, 24, 28, 8, 12), (57, 61, 41, 45, 25, 29, 9, 13))
SUB_CAPTURE_STEPS = (0, 2, -8, -6)


@dataclass(frozen=True, eq=False)
class Layout:
    """A mode.

    grid: rows, columns. sets: before each result line. captures: result lines that make a measurement.
    places: (captures, sets, channels) the zone that channel 1, 2... of a set looks at, row-major.
    """

    grid: tuple[int, int]
    sets: int
    captures: int
    places: np.ndarray

    @property
    def bursts(self) -> int:
        """Sets in a whole measurement."""
        return self.sets * self.captures

    def zones(self, channels: np.ndarray) -> np.ndarray:
        """(zones, ...) from what (captures, sets, 9, ...) the channels hold."""
        used = channels[:, :, : self.places.shape[2]]
        zones = np.empty((self.places.size, *channels.shape[3:]), channels.dtype)
        zones[self.places] = used
        return zones


LAYOUTS = {
    "3x3": Layout((3, 3), 1, 1, np.arange(9).reshape(1, 1, 9)),
    "4x4": Layout((4, 4), 2, 1, np.arange(16).reshape(1, 2, 8)),
    "3x6": Layout((6, 3), 2, 1, np.arange(18).reshape(1, 2, 9)),
    "8x8": Layout((8, 8), 2, 4, np.array([np.array(EIGHT_BY_EIGHT) + step for step in SUB_CAPTURE_STEPS])),
}

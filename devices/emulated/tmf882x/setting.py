"""What the emulated chip is set to, and the table of settings that its firmware has."""

from dataclasses import dataclass

from physics.presets import LAYOUTS
from physics.timing import LASER_HZ

# Period in ms, kilo-iterations and SPAD map of config 0 and 1, by whether the mode is that of the TMF8828.
TABLE = {False: ((16, 10000, 6), (8, 2500, 7)), True: ((132, 10, 15), (264, 2500, 15))}
# What a chip that was never configured has (datasheet: defaults of PERIOD_MS, KILO_ITERATIONS and SPAD_MAP_ID).
CHIP_DEFAULT = (33, 537, 6)
GRIDS = {layout.spad_map_id: layout.zone_grid for layout in LAYOUTS.values()}


@dataclass(frozen=True)
class Setting:
    """A setting. mode_8828: whether the chip measures 8 x 8 zones. config: which row of the table it is.

    period_ms: of measurements, at least. kilo_iterations: of 1024 laser shots, of each burst. ranging: long or short.
    """

    mode_8828: bool
    config: int
    period_ms: int
    kilo_iterations: int
    spad_map: int
    ranging: str = "long"

    @property
    def captures(self) -> int:
        """How many results make all zones: four in 8 x 8 zones."""
        return 4 if self.mode_8828 else 1

    @property
    def bursts(self) -> int:
        """How often each capture fires; a burst sees at most nine zones. Map 14 is the user's, single; 15 is in two."""
        if self.spad_map == 15:
            return 2
        rows, columns = GRIDS.get(self.spad_map, (3, 3))
        return 1 if rows * columns <= 9 else 2

    @property
    def sets(self) -> int:
        """How many sets of ten channels a measurement of all zones has."""
        return self.captures * self.bursts

    @property
    def burst_s(self) -> float:
        """How long a burst fires, seconds."""
        return self.kilo_iterations * 1024 / LASER_HZ

"""What the firmware's settings say, and whether they are what was asked for."""

import re
from dataclasses import dataclass

from calibrate.rig import MODES, LidarSetup
from physics.presets import LAYOUTS
from physics.timing import LASER_HZ

CONF = re.compile(r"#Conf,Period=(\d{1,5})ms,KIter=(\d{1,5}) SPAD=(\d{1,3}) Pers=(\d{1,3})")
# Reading a histogram over I2C, 31 lines a burst; on an Uno with its buffer of 32 bytes it takes longer than 3 ms.
BURST_READ_S = 0.4


@dataclass(frozen=True)
class Setting:
    """As `#Conf` says. period_ms: at least. kilo_iterations: of 1024 laser shots a burst. persistence: 0 is none."""

    period_ms: int
    kilo_iterations: int
    spad_map: int
    persistence: int
    mode_8828: bool

    @property
    def mode(self) -> str | None:
        """Zones, columns x rows; None for maps that the user defines."""
        if self.mode_8828:
            return "8x8"
        grid = next((layout.zone_grid for layout in LAYOUTS.values() if layout.spad_map_id == self.spad_map), None)
        return next((mode for mode, zones in MODES.items() if zones == grid and mode != "8x8"), None)

    def serves(self, setup: LidarSetup) -> bool:
        """Whether it is what was asked for; 0 kilo-iterations ask for none in particular."""
        return self.mode == setup.mode and setup.kilo_iterations in (0, self.kilo_iterations)

    def __str__(self) -> str:
        return f"{self.mode or f'SPAD map {self.spad_map}'} of {self.kilo_iterations} kilo-iterations"


def setting_from(conf: re.Match[str], *, mode_8828: bool) -> Setting:
    """What a line that `CONF` matches says."""
    period_ms, kilo, spad_map, persistence = map(int, conf.groups())
    return Setting(period_ms, kilo, spad_map, persistence, mode_8828)


def measurement_s(mode: str, kilo_iterations: int, period_ms: int) -> float:
    """About how long a measurement takes from its start to its last line, seconds, at most."""
    bursts = {"3x3": 1, "4x4": 2, "3x6": 2, "8x8": 8}[mode]
    return max(bursts * (kilo_iterations * 1024 / LASER_HZ + BURST_READ_S), period_ms / 1000)

"""Sensors ready to use: the TMF8820 and TMF8828 in their modes, each number with its source."""

from dataclasses import dataclass

import numpy as np

from physics.pulse_shape import PulseShape, Tail
from physics.sensor import SensorModel
from physics.timing import BIN_WIDTH_S, BINS, LASER_HZ, PULSE, ZERO_BINS
from recordings.refusal import Refusal

DATASHEET = "TMF882x datasheet DS000693 v8"
# Counts per shot and bin: the lower end of what such sensors see indoors, 1e-5 to 1e-4.
AMBIENT = 1e-5


@dataclass(frozen=True)
class Layout:
    """spad_map_id: as in the datasheet. zone_grid: rows, columns. kilo_cycles: of 1024 laser shots in a frame."""

    spad_map_id: int
    zone_grid: tuple[int, int]
    kilo_cycles: int = 550


LAYOUTS = {
    "3x3-normal": Layout(1, (3, 3)),
    "3x3-macro1": Layout(2, (3, 3)),
    "3x3-macro2": Layout(3, (3, 3)),
    "4x4-macro1": Layout(4, (4, 4)),
    "4x4-macro2": Layout(5, (4, 4)),
    "3x3-wide": Layout(6, (3, 3)),
    "4x4-normal": Layout(7, (4, 4)),
    "3x6": Layout(10, (6, 3)),
    "3x3-checkerboard": Layout(11, (3, 3)),
    "3x3-checkerboard-inverse": Layout(12, (3, 3)),
    "4x4-narrow": Layout(13, (4, 4)),
    "8x8": Layout(15, (8, 8), 125),
}
# The TMF8820 has the 3 × 3 maps alone.
DEVICES = {"tmf8820": [name for name in LAYOUTS if name.startswith("3x3")], "tmf8828": list(LAYOUTS)}
RANGES = ("long", "short")


def preset_names() -> list[str]:
    """Names of all presets, device-layout-range, such as tmf8828-3x3-wide-long."""
    return [f"{d}-{layout}-{r}" for d, layouts in DEVICES.items() for layout in layouts for r in RANGES]


def preset(name: str) -> SensorModel:
    """The preset of this name."""
    if name not in preset_names():
        raise Refusal(f"sensor {name!r} is no preset, expected one such as {', '.join(preset_names()[8:10])}")
    device, _, rest = name.partition("-")
    layout_name, _, ranging = rest.rpartition("-")
    layout = LAYOUTS[layout_name]
    zones = layout.zone_grid[0] * layout.zone_grid[1]
    rise, fall, tau, share = PULSE[ranging]
    cycles = layout.kilo_cycles * 1024
    return SensorModel(
        name=device.upper(),
        mode=f"{layout_name}, {ranging} range",
        zone_grid=layout.zone_grid,
        bins=BINS,
        bin_width_s=BIN_WIDTH_S[ranging],
        time_zero_s=np.resize(ZERO_BINS[ranging], zones) * BIN_WIDTH_S[ranging],
        pulse=PulseShape(rise, fall, (Tail(tau, share),)),
        laser_cycles=cycles,
        laser_hz=LASER_HZ,
        background_counts=np.full(zones, AMBIENT * cycles),
        sources=_sources(layout, ranging),
    )


def _sources(layout: Layout, ranging: str) -> dict[str, str]:
    """Where each number comes from."""
    width = {
        "long": "0.38 ns +- 5 %: 57 mm a bin, between 55.6 and 60 mm read from Figures 23 and 24 of the datasheet",
        "short": "92.5 ps +- 2 %: between published robot-calibrated fits of 73.484 and 71.09 bins/m",
    }[ranging]
    pulse = {
        "long": "assumed, no shape is published: longer than in short range, as 3.57 times the crosstalk suggests",
        "short": "as published TMF8820 histograms of a plane show it",
    }[ranging]
    return {
        "zone_grid": f"{DATASHEET}, spad_map_id {layout.spad_map_id}",
        "bins": f"{DATASHEET}, histogram dump: 128 bins a channel",
        "bin_width_s": width,
        "time_zero_s": "factory calibration of one device in spad_map_id 6, channels 1 to 9 in turn; differs by device",
        "pulse": pulse,
        "laser_cycles": f"{DATASHEET}, performance tables: {layout.kilo_cycles} kilo-iterations of 1024 shots",
        "laser_hz": f"{DATASHEET}: 17.77 MHz, a period of 56.3 ns",
        "background_counts": f"assumed: {AMBIENT:g} counts per shot and bin, the lower end of what is seen indoors",
    }

"""When the TMF882x registers light: bins, time zeros, pulse and internal crosstalk of its two range modes."""

from dataclasses import dataclass

import numpy as np

from physics.pulse import ImpulseResponse, tailed_pulse
from recordings.refusal import Refusal

BINS = 128
LASER_HZ = 17.77e6
# The factory calibration's crosstalk counts are for 4000 kilo-iterations of 1024 shots.
CALIBRATION_CYCLES = 4000 * 1024
STEPS_PER_BIN = 16

# Channels 1 to 9 of one device's factory calibration pages (map 6): peak positions in bins, crosstalk in
# counts.
ZERO_BINS = {
    "long": (15.455, 15.199, 15.183, 15.269, 15.250, 15.484, 15.465, 15.278, 15.215),
    "short": (14.366, 13.973, 13.920, 14.175, 14.098, 14.782, 14.608, 14.111, 13.863),
}
CROSSTALK = {
    "long": (7465, 3709, 4198, 9668, 6056, 3764, 7144, 3972, 4490),
    "short": (2052, 1050, 1171, 2718, 1680, 1029, 2074, 1106, 1275),
}
# Bin widths: 0.38 ns +- 5 % and 92.5 ps +- 2 %, from published fits.
BIN_WIDTH_S = {"long": 0.38e-9, "short": 92.5e-12}
# Rise, fall, tail (seconds) and share of the tail. Short: as TMF8820 histograms of a plane show it. Long: the
# pulse carries 3.57 times the energy (crosstalk, below) and is taken to be longer, since its shape is
# published nowhere.
PULSE = {"long": (0.16e-9, 0.34e-9, 0.45e-9, 0.15), "short": (0.05e-9, 0.13e-9, 0.33e-9, 0.15)}
# Light per shot relative to long range: the ratio of crosstalk, 3.57 +- 0.06 in all nine channels.
ENERGY = {"long": 1.0, "short": 1 / 3.57}


@dataclass(frozen=True, eq=False)
class Timing:
    """How P zones register time in one range mode.

    bin_width_s: seconds. time_zero_s: (P,) arrival of a target at range 0, seconds from the start of bin 0.
    pulse: impulse response. crosstalk: (P,) photons per shot that reach a zone inside the package, at time
    zero.
    energy: light per shot relative to the long-range mode.
    """

    mode: str
    bin_width_s: float
    time_zero_s: np.ndarray
    pulse: ImpulseResponse
    crosstalk: np.ndarray
    energy: float
    bins: int = BINS


def tmf882x_timing(mode: str, zones: int) -> Timing:
    """Timing of `zones` zones in mode "long" or "short"; zone p is measured by channel p mod 9 + 1.

    Maps of more than nine zones are measured in bursts that use the same channels again.
    """
    if mode not in BIN_WIDTH_S:
        raise Refusal(f"range mode is {mode!r}, expected {' or '.join(BIN_WIDTH_S)}")
    width = BIN_WIDTH_S[mode]
    return Timing(
        mode=mode,
        bin_width_s=width,
        time_zero_s=np.resize(ZERO_BINS[mode], zones) * width,
        pulse=tailed_pulse(*PULSE[mode], step_s=width / STEPS_PER_BIN),
        crosstalk=np.resize(CROSSTALK[mode], zones) / CALIBRATION_CYCLES,
        energy=ENERGY[mode],
    )

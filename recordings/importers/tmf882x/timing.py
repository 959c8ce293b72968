"""When the TMF882x registers light in its two range modes: the width of a bin, and the arrival of a target at range 0.

Widths from published fits (0.38 ns +- 5 %, 92.5 ps +- 2 %), zeros of channels 1 to 9 from one device's factory
calibration pages of SPAD map 6, in bins; other devices differ by about 50 ps a channel.
"""

import numpy as np

from recordings.importers.tmf882x.layout import Layout

BIN_WIDTH_S = {"long": 0.38e-9, "short": 92.5e-12}
ZERO_BINS = {
    "long": (15.455, 15.199, 15.183, 15.269, 15.250, 15.484, 15.465, 15.278, 15.215),
    "short": (14.366, 13.973, 13.920, 14.175, 14.098, 14.782, 14.608, 14.111, 13.863),
}


def time_zero_s(layout: Layout, ranging: str) -> np.ndarray:
    """(P,) seconds from the start of bin 0; each zone has the zero of the channel it is measured by."""
    zeros = np.array(ZERO_BINS[ranging]) * BIN_WIDTH_S[ranging]
    return layout.zones(np.tile(zeros, (layout.captures, layout.sets, 1)))

"""What of a pulse, and of a histogram, is in its largest bin."""

import numpy as np

from physics.arrivals import Arrivals
from physics.pulse import ImpulseResponse

# A bin is gone through in so many steps to see what its largest share of a pulse is.
PHASES = 64


def largest_share(pulse: ImpulseResponse, bin_width_s: float) -> np.ndarray:
    """(PHASES,) share of a pulse in its largest bin, by where in a bin it arrives, from its start on."""
    first, last = (int(np.floor(end / bin_width_s)) for end in pulse.edges[[0, -1]])
    edges = np.arange(first, last + 3) - np.arange(PHASES)[:, None] / PHASES
    return np.diff(pulse.cumulative(edges * bin_width_s), axis=-1).max(axis=-1)


def largest_part(arrivals: Arrivals) -> np.ndarray:
    """(F, P) part of the light of each zone and frame, of what the window sees, in its largest bin; 1 where is none."""
    binned = arrivals.binned()
    total = binned.sum(axis=-1)
    return np.where(total > 0, binned.max(axis=-1) / np.where(total > 0, total, 1), 1.0)

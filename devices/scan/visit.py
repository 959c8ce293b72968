"""One position of a scan, before and after what was seen there is known."""

from dataclasses import dataclass

import numpy as np

from calibrate.patch_edge import Disc
from devices.captures import Settled
from devices.scan.journal import Sample
from devices.scan.station import Look


@dataclass(frozen=True, eq=False)
class Seen:
    """What a listener hears after every position: the sample, the picture, where the patch was found in it.

    done, planned: positions of all passes so far, and how many there will be at most.
    """

    sample: Sample
    rgb: np.ndarray | None
    patch: Disc | None
    done: int
    planned: int


@dataclass(frozen=True, eq=False)
class Visit:
    """A position at which was looked, and what was seen there, perhaps not read out yet."""

    name: str
    cell: int
    settled: Settled
    look: Look

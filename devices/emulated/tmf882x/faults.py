"""What goes wrong between an emulated sensor and whoever listens."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Faults:
    """lose, garble: shares of lines that do not arrive, or arrive with a byte changed.

    unplug_at, stall_at: the results, counted from 0 and four of them a measurement of 8 x 8 zones, in the midst of
    whose lines the cable is pulled or the line stands still, each once. back_after_s, stall_s: for how long, seconds of
    the sensor's clock; infinity is for good.
    """

    lose: float = 0.0
    garble: float = 0.0
    unplug_at: tuple[int, ...] = ()
    back_after_s: float = 1.0
    stall_at: tuple[int, ...] = ()
    stall_s: float = 1.0


NO_FAULTS = Faults()


def damaged(line: bytes, faults: Faults, rng: np.random.Generator) -> bytes:
    """What is left of a line that was sent."""
    fate = rng.random() if faults.lose or faults.garble else 1.0
    if fate < faults.lose:
        return b""
    if fate < faults.lose + faults.garble:
        # Flipping bit 7 makes any byte of these lines one that none of them holds.
        at = int(rng.integers(len(line)))
        return line[:at] + bytes([line[at] ^ 0x80]) + line[at + 1 :]
    return line

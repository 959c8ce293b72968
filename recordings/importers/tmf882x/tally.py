"""What was lost on the way, counted."""

from collections import Counter
from dataclasses import dataclass, field
from typing import Any


@dataclass
class Tally:
    """Counts since the beginning.

    lines: all that came. frames: whole measurements handed on. dropped: measurements of which something came, but not
    all, or not in order. missed: measurements that the sensor counted and that were not handed on, dropped or never
    seen. damaged: lines that begin as data and are none. foreign: other lines of text. calibration: histograms of the
    electrical calibration, which are passed over. reasons: why measurements were dropped and lines are damaged.
    """

    lines: int = 0
    frames: int = 0
    dropped: int = 0
    missed: int = 0
    damaged: int = 0
    foreign: int = 0
    calibration: int = 0
    reasons: Counter[str] = field(default_factory=Counter)

    def said(self) -> dict[str, Any]:
        """The counts as plain values for a recording's metadata."""
        return {**vars(self), "reasons": dict(self.reasons)}

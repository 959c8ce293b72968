"""The frames of a VL53L8CH's log: a line `D`, then one line for each aggregate of zones, all of them, in order.

A line is `aggregate ambient distance bin0 bin1 ...`, whole numbers between single blanks; the ambient light and the
bins are a thousandfold what the chip says, and the chip took the ambient light out of the bins.
"""

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from recordings.refusal import Refusal

BEGIN = b"D"
LONGEST_LINE = 1 << 14
LARGEST = 1 << 31
NUMBERS = re.compile(rb"-?\d{1,10}(?: -?\d{1,10}){3,}")


@dataclass(frozen=True, eq=False)
class Vl53Frame:
    """line: in which it begins. ambient, distance_mm: (P,) int64. bins: (P, T) int64 without ambient light."""

    line: int
    ambient: np.ndarray
    distance_mm: np.ndarray
    bins: np.ndarray


@dataclass
class Lost:
    """Frames that were left out, by reason; first: the line of the first."""

    reasons: Counter[str] = field(default_factory=Counter)
    first: int | None = None

    def add(self, line: int, reason: str) -> None:
        """One more."""
        self.reasons[reason] += 1
        self.first = line if self.first is None else self.first


def numbered_lines(path: Path) -> Iterator[tuple[int, bytes]]:
    """Number and text, without its end, of each line."""
    with path.open("rb") as file:
        number = 0
        while line := file.readline(LONGEST_LINE):
            number += 1
            yield number, line.rstrip(b"\r\n")


def read_frames(path: Path) -> tuple[list[Vl53Frame], Lost]:
    """The whole frames of a log, alike in size; `Refusal` names a line where there is none."""
    groups, lost = [], Lost()
    for number, text in numbered_lines(path):
        if text == BEGIN:
            groups.append((number, []))
        elif groups:
            groups[-1][1].append(text)
    frames = []
    for number, lines in groups:
        frame = whole(number, lines)
        if isinstance(frame, str):
            lost.add(number, frame)
        else:
            frames.append(frame)
    if not frames:
        where = f"line {lost.first}: {next(iter(lost.reasons))}" if lost.reasons else "line 1: no line D begins one"
        raise Refusal(f"{path}: holds no whole frame, {where}")
    usual, _ = Counter(frame.bins.shape for frame in frames).most_common(1)[0]
    for frame in frames:
        if frame.bins.shape != usual:
            lost.add(frame.line, "lines or bins are missing")
    return [frame for frame in frames if frame.bins.shape == usual], lost


def whole(line: int, lines: list[bytes]) -> Vl53Frame | str:
    """A frame, or what is wrong with it."""
    while lines and not lines[-1]:
        lines = lines[:-1]
    if not lines:
        return "no aggregates"
    if not all(NUMBERS.fullmatch(text) for text in lines):
        return "a line is no row of whole numbers"
    rows = [[int(number) for number in text.split(b" ")] for text in lines]
    if any(len(row) != len(rows[0]) for row in rows):
        return "lines or bins are missing"
    table = np.array(rows, np.int64)
    if (table[:, 0] != np.arange(len(table))).any():
        return "an aggregate is missing, twice there or out of order"
    if np.abs(table).max() >= LARGEST:
        return "a number beyond 32 bits"
    return Vl53Frame(line, table[:, 1], table[:, 2], table[:, 3:])

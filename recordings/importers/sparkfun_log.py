"""Importer of what the histogram example of SparkFun's TMF882X library printed, kept as text.

`Histogram Number: n`, then `#HLONG`, the channel's digit and, with nothing between, 128 counts, for channels 0 to 9 in
turn; channel 0 is the reference. Nothing says the mode or the range, nor is there a time. A frame is taken if its
channels are whole and the next number follows; of the last, that cannot be told.
"""

import json
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from recordings.head import head
from recordings.importers.tmf882x.layout import LAYOUTS
from recordings.importers.tmf882x.lines import BINS, CHANNELS
from recordings.importers.tmf882x.survey import numbered_lines
from recordings.importers.tmf882x.timing import BIN_WIDTH_S, time_zero_s
from recordings.refusal import Refusal
from recordings.stream import Stream

COUNT = rb"(?:0|[1-9]\d{0,9})"
CHANNEL = re.compile(rb"#HLONG(\d)(%b(?:,%b){%d})" % (COUNT, COUNT, BINS - 1))
HEADER = re.compile(rb"Histogram Number: ([1-9]\d{0,9})")
# Counts have 24 bits.
MOST = (1 << 24) - 1


@dataclass
class Log:
    """numbers: of the frames. counts: (10, 128) uint32 of each, channel 0 the reference. lost: others, by reason."""

    numbers: list[int] = field(default_factory=list)
    counts: list[np.ndarray] = field(default_factory=list)
    lost: Counter[str] = field(default_factory=Counter)


def reads(path: Path) -> bool:
    """Whether a line among the first begins as a channel of the example does."""
    return any(re.match(rb"#HLONG\d\d", line) for line in head(path).split(b"\n"))


def stream(path: Path) -> Stream:
    """The whole frames of the log, those of a range and mode that is assumed; `Refusal` where there is none."""
    log = Log()
    for number, lines, after in groups(path):
        counts = channels(lines)
        # The next header must follow: else lines were lost over the end of this one, and these may be of two.
        if isinstance(counts, str) or after not in (None, number + 1):
            log.lost[counts if isinstance(counts, str) else "the next number does not follow"] += 1
        elif log.numbers and number <= log.numbers[-1]:
            log.lost["its number does not rise"] += 1
        else:
            log.numbers.append(number)
            log.counts.append(counts)
    if not log.numbers:
        why = ", ".join(f"{reason} ({count})" for reason, count in log.lost.items()) or "line 1: no Histogram Number"
        raise Refusal(f"{path}: holds no whole frame, {why}")
    layout = LAYOUTS["3x3"]
    static: dict[str, Any] = {
        "zone_grid": np.array(layout.grid),
        "bin_width_s": np.array(BIN_WIDTH_S["long"]),
        "time_zero_s": time_zero_s(layout, "long"),
        "meta_json": json.dumps(described(log)),
    }
    passing = (
        {"counts": one[1:], "timestamp_s": float(number)} for number, one in zip(log.numbers, log.counts, strict=True)
    )
    return Stream(static=static, frames=passing, count=len(log.numbers))


def groups(path: Path) -> Iterator[tuple[int, list[bytes], int | None]]:
    """Number of each frame, its lines that are not empty, and the number after it, None at the end of the file."""
    number, lines = None, []
    for _, line in numbered_lines(path):
        text = line.removesuffix(b"\r")
        if match := HEADER.fullmatch(text):
            if number is not None:
                yield number, lines, int(match[1])
            number, lines = int(match[1]), []
        elif text:
            lines.append(text)
    if number is not None:
        yield number, lines, None


def channels(lines: list[bytes]) -> np.ndarray | str:
    """(10, 128) uint32, or what is wrong with the lines."""
    matches = [CHANNEL.fullmatch(line) for line in lines]
    if None in matches:
        return "a line is no channel"
    if [int(match[1]) for match in matches] != list(range(CHANNELS)):
        return "a channel is missing, twice there or out of order"
    counts = np.array([[int(count) for count in match[2].split(b",")] for match in matches])
    return counts.astype(np.uint32) if counts.max() <= MOST else "a count beyond 24 bits"


def described(log: Log) -> dict[str, Any]:
    """The recording's metadata: what is assumed, what was lost, the reference."""
    return {
        "sensor": "TMF882x",
        "mode": "3x3, long range",
        "provenance": "serial log of SparkFun's histogram example",
        "assumed": [
            "mode 3x3, long range: the log does not say; of modes in several bursts each would be a frame",
            f"bin_width_s: {BIN_WIDTH_S['long']:.3g} s, published fits of long range",
            "time_zero_s: factory calibration page of one device",
            "timestamp_s: the frame's number, one a second",
        ],
        "lost": dict(log.lost),
        "number": log.numbers,
        "reference_counts": [one[0].tolist() for one in log.counts],
    }

"""Importer of what a VL53L8CH printed with the firmware of the published captures, kept as text.

The chip takes the ambient light out of its histograms, so that bins may be negative; counts are not. What the chip took
out, which it says in each line, is added again.
"""

import itertools
import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from recordings.head import head
from recordings.importers.vl53l8ch.frames import BEGIN, NUMBERS, Lost, Vl53Frame, read_frames
from recordings.refusal import Refusal
from recordings.stream import Stream

# Nominal.
BIN_WIDTH_S = 250e-12


def reads(path: Path) -> bool:
    """Whether, among the first lines, a `D` stands before a row of whole numbers that begins with 0."""
    lines = [line.rstrip(b"\r") for line in head(path).split(b"\n")]
    after = itertools.pairwise(lines)
    return any(one == BEGIN and two.startswith(b"0 ") and NUMBERS.fullmatch(two) is not None for one, two in after)


def stream(path: Path, add_ambient: bool = True) -> Stream:
    """The whole frames of the log; those that are not are counted in the metadata.

    add_ambient: add to each bin the ambient light that the chip took out of it; without, a negative bin is refused.
    `Refusal` names the line.
    """
    frames, lost = read_frames(path)
    bins = np.stack([frame.bins for frame in frames])
    if add_ambient:
        bins = bins + np.stack([frame.ambient for frame in frames])[:, :, None]
    elif bins.min() < 0:
        frame, zone, at = np.argwhere(bins < 0)[0]
        line = frames[frame].line + 1 + zone
        raise Refusal(
            f"{path}: line {line}: bin {at} is {bins[frame, zone, at]}, expected 0 or more; add the ambient light"
        )
    below = int((bins < 0).sum())
    counts = np.maximum(bins, 0).astype(np.uint32)
    grid = grid_of(counts.shape[1])
    static: dict[str, Any] = {
        "zone_grid": np.array(grid),
        "bin_width_s": np.array(BIN_WIDTH_S),
        "time_zero_s": np.array(0.0),
        "meta_json": json.dumps(described(frames, lost, grid, add_ambient, below)),
    }
    passing = ({"counts": one, "timestamp_s": float(i)} for i, one in enumerate(counts))
    return Stream(static=static, frames=passing, count=len(frames))


def grid_of(aggregates: int) -> tuple[int, int]:
    """Rows and columns: a square where that is one, else one row."""
    side = math.isqrt(aggregates)
    return (side, side) if side * side == aggregates else (1, aggregates)


def described(
    frames: list[Vl53Frame], lost: Lost, grid: tuple[int, int], add_ambient: bool, below: int
) -> dict[str, Any]:
    """The recording's metadata: what the counts are, what is assumed, what was lost, what the chip found."""
    zero = "as the ambient light of the whole line was added" if add_ambient else "as there were none"
    return {
        "sensor": "VL53L8CH",
        "mode": f"{grid[1]}x{grid[0]}",
        "provenance": "serial log of a VL53L8CH",
        "counts": "a thousand of the chip's own units each, whose noise is not that of photons counted one by one",
        "ambient": "added to every bin" if add_ambient else "taken out on the chip",
        "cells_below_zero": {"count": below, "became": f"0, {zero}"},
        "assumed": [
            "bin_width_s: nominal, every bin sent, none joined",
            "time_zero_s: the start of the first bin; the log does not say which bin that is",
            "timestamp_s: one frame a second, as the log says no time",
            f"zone_grid: {grid[0]} rows of {grid[1]}, by the number of aggregates",
        ],
        "lost": dict(lost.reasons),
        "on_chip": {
            "distance_mm": [frame.distance_mm.tolist() for frame in frames],
            "ambient": [frame.ambient.tolist() for frame in frames],
        },
    }

"""Importer of the makers' log of a TMF8829: JSON, packed by gzip or not, with histograms of each zone."""

import gzip
import itertools
import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from recordings.importers.tmf8829.bins import Bins, fitted
from recordings.importers.tmf8829.frames import GZIP, Tmf8829Frames, read_frames
from recordings.refusal import Refusal
from recordings.stream import Stream

SNIFFED_BYTES = 1 << 18


def reads(path: Path) -> bool:
    """Whether the file, unpacked, starts as a JSON object with a list of results."""
    try:
        with path.open("rb") as file:
            packed = file.read(2) == GZIP
        with gzip.open(path) if packed else path.open("rb") as file:
            head = file.read(SNIFFED_BYTES)
    except (OSError, EOFError, gzip.zlib.error):
        return False
    return head.removeprefix(b"\xef\xbb\xbf").lstrip()[:1] == b"{" and b'"Result_Set"' in head


def stream(path: Path, bins: Bins | None = None) -> Stream:
    """The frames with histograms; `Refusal` names the frame and field at fault.

    bins: width and zero; without them, from the chip's own distances. In dual mode the histograms of the longer range.
    """
    frames = read_frames(path)
    count, rows, columns, length = frames.counts.shape
    timing = bins or fitted(frames.counts.reshape(-1, length), frames.distance_m.ravel())
    if timing is None:
        raise Refusal(
            f"{path}: the width of a bin is not published, and the distances beside the histograms are too few or too "
            f"alike to tell it, expected results of targets at several distances"
        )
    times, assumed = times_s(frames)
    static: dict[str, Any] = {
        "zone_grid": np.array([rows, columns]),
        "bin_width_s": np.array(timing.width_s),
        "time_zero_s": np.array(timing.zero_s),
        "meta_json": json.dumps(described(frames, timing, bins is None, assumed)),
    }
    zones = frames.counts.reshape(count, -1, length)
    passing = ({"counts": one, "timestamp_s": time} for one, time in zip(zones, times, strict=True))
    return Stream(static=static, frames=passing, count=count)


def times_s(frames: Tmf8829Frames) -> tuple[list[float], str]:
    """Seconds of each frame, and what they are assumed from: the unit of the chip's clock is not published."""
    numbers = [one.get("frame_number") if isinstance(one, dict) else None for one in frames.info]
    whole = all(type(number) is int and abs(number) < 1 << 53 for number in numbers)
    if whole and all(later > earlier for earlier, later in itertools.pairwise(numbers)):
        return [float(number - numbers[0]) for number in numbers], "timestamp_s: frame_number, one a second"
    return [float(i) for i in range(len(numbers))], "timestamp_s: one frame a second, as frame_number does not rise"


def described(frames: Tmf8829Frames, timing: Bins, was_fitted: bool, times: str) -> dict[str, Any]:
    """The recording's metadata: what the log says besides, what is assumed, what was left out."""
    line = f"line through {timing.pairs} distances the chip found, over its highest bins"
    rows, columns, length = frames.counts.shape[1:]
    return {
        "sensor": "TMF8829",
        "mode": f"{columns}x{rows}, {length} bins" + (", high accuracy" if frames.histograms.endswith("_HA") else ""),
        "provenance": f"the makers' log, histograms {frames.histograms}",
        "assumed": [f"bin_width_s, time_zero_s: {line if was_fitted else 'as given'}", times],
        "frames_without_histograms": frames.left_out,
        "reference_counts": plain(frames.reference),
        "frame_info": plain(frames.info),
        "on_chip": {"distance_mm": plain((frames.distance_m * 1e3).tolist())},
        "log": plain(frames.besides),
    }


def plain(value: Any) -> Any:
    """JSON values with None for numbers that JSON cannot hold."""
    if isinstance(value, dict):
        return {name: plain(one) for name, one in value.items()}
    if isinstance(value, list):
        return [plain(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value

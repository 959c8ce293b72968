"""Save what is whole of a recording whose writing was interrupted, or whose file was cut off or damaged."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from recordings.fields import FIELDS, IMAGES
from recordings.files import save
from recordings.progress import Progress, silent
from recordings.refusal import Refusal
from recordings.rrd.index import found_index
from recordings.rrd.reader import KIND, static_value
from recordings.rrd.rows import RrdRows
from recordings.stream import Stream
from recordings.untrusted import reading

IRF = ("irf_time_s", "irf")


@dataclass(frozen=True)
class Repaired:
    """What a repair kept and lost.

    frames: how many were kept; incomplete: numbers of frames that were begun but lack a field or are damaged;
    fields: optional fields of the whole recording that were damaged and left out;
    damaged_messages: how many parts of the file could not be read; cut_bytes: bytes after the last whole part.
    """

    frames: int
    incomplete: tuple[int, ...]
    fields: tuple[str, ...]
    damaged_messages: int
    cut_bytes: int


def repair(broken: str | Path, out: str | Path, progress: Progress = silent) -> Repaired:
    """Write the frames of BROKEN for which every field is there and undamaged to OUT, a whole recording.

    BROKEN may be PATH.partial of an interrupted recording or an .rrd that was cut off anywhere; it is left as it
    is. Entities that are no part of the recording are not copied. Refuses a file in which no frame is whole.
    """
    broken = Path(broken)
    if Path(out).suffix != ".rrd":
        raise Refusal(f"{out}: expected a name that ends in .rrd")
    if Path(out).exists() and Path(out).samefile(broken):
        raise Refusal(f"{out}: is the file to repair, expected another name so that nothing is lost")
    with reading(broken, KIND), open(broken, "rb") as file:
        places, damaged, end = found_index(file)
        size = broken.stat().st_size
        if not places:
            raise Refusal(f"nothing can be read of its {size} bytes")
        rows = RrdRows(broken, file, places)
        kept = rows.complete()
        if not kept.any():
            raise Refusal("no frame is whole")
        static, left_out = whole_fields(rows)
        save(Stream(static, whole_frames(rows, kept), int(kept.sum())), out, progress)
    lost = tuple(int(frame) for frame in rows.frames[~kept])
    return Repaired(int(kept.sum()), lost, left_out, damaged, size - end)


def whole_fields(rows: RrdRows) -> tuple[dict[str, Any], tuple[str, ...]]:
    """The fields that hold for all frames, and the names of those that are damaged but can be done without."""
    static, left_out = {}, []
    for name in rows.layout.static:
        try:
            with reading(rows.path, KIND):
                static[name] = static_value(rows, name)
        except Refusal:
            if name in FIELDS and FIELDS[name].required:
                raise
            left_out.append(name)
    # One half of an impulse response is of no use without the other.
    halves = [name for name in IRF if name in static]
    if len(halves) == 1:
        left_out.append(halves[0])
        del static[halves[0]]
    return static, tuple(left_out)


def whole_frames(rows: RrdRows, kept: np.ndarray) -> Iterator[dict[str, Any]]:
    """The frames of `rows` that are kept, colour images as the bytes they are."""
    small = {name: rows.moving(name)[0] for name in rows.layout.frames if name not in IMAGES}
    for i in np.flatnonzero(kept):
        frame = {}
        for name, kind in rows.layout.frames.items():
            if name not in IMAGES:
                frame[name] = small[name][i]
                continue
            image = rows.image(name, int(rows.frames[i]))
            frame[name] = image if name == "rgb" else np.frombuffer(image, kind.dtype).reshape(kind.shape)
        yield frame

"""Read a recording from an .rrd file; images stay in the file until they are asked for."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from recordings.encoded import EncodedFrames, LazyFrames, decoded
from recordings.fields import FIELDS, IMAGES
from recordings.one_field import check_values
from recordings.recording import Recording
from recordings.refusal import Refusal
from recordings.rrd.rows import RrdRows
from recordings.untrusted import reading

# Images other than colour up to this many bytes in all are read at once, larger ones on demand.
EAGER_BYTES = 256 << 20
KIND = ".rrd file"


def load_rrd(path: str | Path) -> Recording:
    """The recording in an .rrd file; refuses one that is cut off, damaged, or not a recording of this project.

    Counts and all small arrays are read at once. Colour frames are decoded when they are asked for, and other
    images too where they are large; such a frame is refused then, if it is damaged.
    """
    with reading(path, KIND):
        rows = RrdRows.open(path)
        check_numbers(rows)
        static = {name: static_value(rows, name) for name in rows.layout.static}
        moving = {name: moving_value(rows, name) for name in rows.layout.frames}
        return Recording(**static, **moving)


def check_numbers(rows: RrdRows) -> None:
    """Refuse a file whose frames are not numbered 0, 1, 2 and so on."""
    wrong = rows.frames != np.arange(len(rows.frames))
    if wrong.any():
        raise Refusal(f"frame {int(np.argmax(wrong))} is missing; `difflidar repair` saves the others")


def static_value(rows: RrdRows, name: str) -> Any:
    """A field that holds for all frames, images decoded."""
    value = rows.static(name)
    return decoded(value, rows.layout.static[name].shape[:2], name) if name == "rgb" else value


def moving_value(rows: RrdRows, name: str) -> np.ndarray | LazyFrames:
    """A field of every frame: an array, or frames that are read on demand."""
    if name in IMAGES:
        return images(rows, name)
    values, good = rows.moving(name)
    if not good.all():
        frame = int(np.argmin(good))
        raise Refusal(f"{name}[{frame}] is missing or damaged; `difflidar repair` saves the other frames")
    return values


def images(rows: RrdRows, name: str) -> np.ndarray | LazyFrames:
    """Images of every frame, on demand where they are colour or large."""
    kept = rows.layout.frames[name]
    count = len(rows.frames)
    if not rows.covers(name):
        raise Refusal(f"{name} has no image for some frames; `difflidar repair` saves the others")
    if name == "rgb":
        return EncodedFrames(named(rows, lambda i: rows.image(name, i)), count, kept.shape[:2])

    def read(i: int) -> np.ndarray:
        image = np.frombuffer(rows.image(name, i), kept.dtype).reshape(kept.shape)
        check_values(name, image, FIELDS[name], i)
        return image

    frames = LazyFrames((count, *kept.shape), kept.dtype, named(rows, read))
    return np.asarray(frames) if frames.nbytes <= EAGER_BYTES else frames


def named(rows: RrdRows, read: Callable[[int], Any]) -> Callable[[int], Any]:
    """`read`, with errors that name the file."""

    def reads(i: int) -> Any:
        with reading(rows.path, KIND):
            return read(i)

    return reads


def verify(path: Path, count: int) -> None:
    """Read back every row of a file that was just written; refuses it where it is not whole."""
    with reading(path, KIND):
        rows = RrdRows.open(path)
        check_numbers(rows)
        for name in rows.layout.static:
            rows.static(name)
        whole = int(rows.complete().sum())
        if whole != count:
            raise Refusal(f"{whole} frames were read back of {count} that were written")

"""The exchange form of a recording: an .npz with one array for each field."""

import tempfile
import zipfile
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import IO, Any

import numpy as np

from recordings.encoded import decoded
from recordings.fields import FIELDS, IMAGES, varies
from recordings.frame_checks import FrameChecks
from recordings.npz_members import Member, members, save_array, text
from recordings.one_field import check_shape
from recordings.progress import Progress, silent
from recordings.recording import Recording
from recordings.refusal import Refusal
from recordings.stream import Stream
from recordings.untrusted import reading

KIND = ".npz recording"
META = "meta_json"


def load_npz(path: str | Path) -> Recording:
    """The recording in an .npz, in memory; refuses anything but plain arrays of the format."""
    with reading(path, KIND), zipfile.ZipFile(path) as archive:
        values = {name: value(archive, member) for name, member in fields(archive).items()}
        return Recording(**values)


def stream_npz(path: str | Path) -> Stream:
    """The same, frame by frame; images are read as they are asked for."""
    with reading(path, KIND), zipfile.ZipFile(path) as archive:
        found = fields(archive)
        moving = {n: m for n, m in found.items() if n != META and varies(n, len(m.shape))}
        large = {n: m for n, m in moving.items() if n in IMAGES}
        small = {n: value(archive, m) for n, m in found.items() if n not in large}
    static = {n: v for n, v in small.items() if n not in moving}
    count = moving["counts"].shape[0]

    def frames() -> Iterator[dict[str, Any]]:
        with ExitStack() as open_files:
            with reading(path, KIND):
                archives = {n: open_files.enter_context(zipfile.ZipFile(path)) for n in large}
            rows = {n: m.rows(archives[n]) for n, m in large.items()}
            for i in range(count):
                with reading(path, KIND):
                    frame = {n: next(rows[n]) if n in rows else small[n][i] for n in moving}
                yield frame

    return Stream(static, frames(), count)


def fields(archive: zipfile.ZipFile) -> dict[str, Member]:
    """The arrays of the format in an archive, their shapes checked; other plain arrays are left alone."""
    every = members(archive)
    if "responses" in every and "counts" not in every:
        raise Refusal("holds response maps, expected a recording")
    sizes: dict[str, int] = {}
    for name, field in FIELDS.items():
        if name in every:
            check_shape(name, every[name].shape, field.shapes, sizes)
        elif field.required:
            raise Refusal(f"{name} is missing, expected {field.expected}")
    return {name: every[name] for name in (*FIELDS, META) if name in every}


def value(archive: zipfile.ZipFile, member: Member) -> Any:
    """The array of a member, or the text that `meta_json` is."""
    array = member.whole(archive)
    return text(array, META) if member.name == META else array


def save_npz(stream: Stream, path: Path, progress: Progress = silent) -> None:
    """Write a stream to `path` as it comes; the frames wait in unnamed files beside it, not in memory."""
    checks = FrameChecks(stream.static)
    with ExitStack() as spools:
        files: dict[str, IO[bytes]] = {}
        kinds: dict[str, np.ndarray] = {}
        for frame in progress(stream.frames, stream.count, "reading frames"):
            for name, plain in checks.frame(frame).items():
                pixels = decoded(plain, checks.image_shape[:2], name) if isinstance(plain, bytes) else plain
                if name not in files:
                    files[name] = spools.enter_context(tempfile.TemporaryFile(dir=path.parent))
                    kinds[name] = pixels
                files[name].write(np.ascontiguousarray(pixels).data)
        if not checks.count:
            raise Refusal("the recording has no frame, expected at least one")
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
            for name in progress(list(FIELDS), len(FIELDS), "writing arrays"):
                if name in files:
                    files[name].seek(0)
                    shape = (checks.count, *kinds[name].shape)
                    save_array(archive, name, kinds[name].dtype, shape, files[name])
                elif name in checks.static:
                    array = checks.static[name]
                    if isinstance(array, bytes):
                        array = decoded(array, checks.image_shape[:2], name)
                    save_array(archive, name, array.dtype, array.shape, array)
            meta = np.array(checks.static[META])
            save_array(archive, META, meta.dtype, meta.shape, meta)

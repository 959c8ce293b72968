"""Recordings by the name of their file: any form in, .rrd or .npz out."""

import errno
import importlib
import pkgutil
import zipfile
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Literal

import recordings.importers
from recordings.atomic import written_aside
from recordings.maps import ResponseMaps
from recordings.npz import load_npz, save_npz, stream_npz
from recordings.progress import Progress, silent
from recordings.recording import Recording
from recordings.refusal import Refusal
from recordings.rrd.reader import load_rrd
from recordings.rrd.writer import PARTIAL, RrdWriter, partial_path
from recordings.stream import Stream
from recordings.untrusted import reading

MAGIC = {b"RRF2": ".rrd", b"PK\x03\x04": ".npz", b"PK\x05\x06": ".npz"}
WRITTEN = (".rrd", ".npz")
# A full disk, a full quota, a file larger than is allowed.
NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)


def load(path: str | Path) -> Recording:
    """The recording in a file of any form that is known, by what the file is; refuses others in a sentence."""
    path = Path(path)
    kind = kind_of(path)
    if kind == ".rrd":
        return load_rrd(path)
    if kind == ".npz":
        return load_npz(path)
    return kind.stream(path).collect()


def stream(path: str | Path) -> Stream:
    """The same, frame by frame, for recordings that do not fit in memory."""
    path = Path(path)
    kind = kind_of(path)
    if kind == ".rrd":
        return Stream.of(load_rrd(path))
    if kind == ".npz":
        return stream_npz(path)
    return kind.stream(path)


def holds_maps(path: str | Path) -> bool:
    """Whether a file is response maps, by its arrays."""
    path = Path(path)
    if kind_of(path) != ".npz":
        return False
    with reading(path, "archive (.npz)"), zipfile.ZipFile(path) as archive:
        return "responses.npy" in archive.namelist()


def maps_of(path: str | Path) -> ResponseMaps | None:
    """The response maps that published data carry beside the recording, or None."""
    path = Path(path)
    kind = kind_of(path)
    return None if isinstance(kind, str) or not hasattr(kind, "maps") else kind.maps(path)


def save(recording: Recording | Stream, path: str | Path, progress: Progress = silent) -> None:
    """Write a recording to PATH.rrd or PATH.npz, whole or not at all."""
    path = Path(path)
    if path.suffix not in WRITTEN:
        raise Refusal(f"{path}: expected a name that ends in {' or '.join(WRITTEN)}")
    passing = Stream.of(recording) if isinstance(recording, Recording) else recording
    with written_aside(path) as aside:
        try:
            if path.suffix == ".npz":
                save_npz(passing, aside, progress)
            else:
                save_rrd(passing, aside, progress)
        except OSError as wrong:
            if wrong.errno in NO_ROOM:
                wrong.filename = str(path)
            raise
        finally:
            partial_path(aside).unlink(missing_ok=True)


def save_rrd(passing: Stream, path: Path, progress: Progress) -> None:
    """Write a stream frame by frame."""
    with RrdWriter(path, passing.static) as writer:
        for frame in progress(passing.frames, passing.count, "writing frames"):
            writer.append(frame)


def kind_of(path: Path) -> Literal[".rrd", ".npz"] | ModuleType:
    """What a file is by its first bytes: a form of ours, or the importer that reads it."""
    if path.name.endswith(PARTIAL):
        raise Refusal(f"{path}: a recording that was interrupted; `difflidar repair {path} OUT.rrd` saves it")
    if not path.exists() and partial_path(path).exists():
        raise Refusal(
            f"{path}: no such file, but {partial_path(path).name} is there from a recording that was "
            f"interrupted; `difflidar repair {partial_path(path)} {path}` saves it"
        )
    if not path.is_dir():
        with open(path, "rb") as file:
            kind = MAGIC.get(file.read(4))
        if kind is not None:
            if path.suffix in WRITTEN and path.suffix != kind:
                raise Refusal(f"{path}: holds a file of kind {kind}, expected {path.suffix} by its name; rename it")
            return kind
        if path.suffix in WRITTEN:
            raise Refusal(f"{path}: is no {path.suffix} file, though its name says so")
    for importer in importers():
        if importer.reads(path):
            return importer
    raise Refusal(f"{path}: neither .rrd nor .npz nor data of a published form that is known")


def importers() -> Iterator[ModuleType]:
    """Readers of published data, each a file in `recordings/importers`."""
    for found in pkgutil.iter_modules(recordings.importers.__path__):
        if not found.ispkg:
            yield importlib.import_module(f"recordings.importers.{found.name}")

"""The rows of a recording in an .rrd file: by field and frame, each checked against its checksum."""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import pyarrow as pa

from recordings.fields import IMAGES
from recordings.refusal import Refusal
from recordings.rrd.arrays import byte_strings, column, numbers
from recordings.rrd.images import RrdImages
from recordings.rrd.index import ChunkPlace, written_index
from recordings.rrd.layout import CHECKSUMS, COUNTS, LAYOUT, META, OWN, Layout, checksum, place


class RrdRows:
    """A recording in an open .rrd file whose chunks are at `places`.

    layout: which fields there are; frames: (n,) sorted numbers of the frames that were written.
    Errors are those of decoders; `untrusted.reading` makes refusals of them.
    """

    def __init__(self, path: str | Path, file: BinaryIO, places: Sequence[ChunkPlace]) -> None:
        self.path = Path(path)
        self._file = file
        self._still: dict[str, list[ChunkPlace]] = defaultdict(list)
        self._moving: dict[str, list[ChunkPlace]] = defaultdict(list)
        for there in places:
            (self._still if there.static else self._moving)[there.entity].append(there)
        described = self._last(OWN, LAYOUT)
        if described is None:
            raise Refusal("is a rerun file, but not a recording of difflidar")
        self.layout = Layout.read(described.flatten()[0].as_py())
        width = len(self.layout.frames)
        pieces = [(f, numbers(s, CHECKSUMS, np.dtype(np.uint32), (width,))) for f, s in self._rows(OWN, CHECKSUMS)]
        if not pieces:
            raise Refusal("holds no whole frame")
        every = np.concatenate([frames for frames, _ in pieces])
        self.frames, first = np.unique(every, return_index=True)
        self._sums = np.concatenate([sums for _, sums in pieces])[first]
        images = {name: place(name) for name in self.layout.frames if name in IMAGES}
        self._images = {name: RrdImages(file, component, self._moving[e]) for name, (e, component) in images.items()}

    @classmethod
    def open(cls, path: str | Path) -> "RrdRows":
        """The recording in a finished file."""
        file = open(path, "rb")  # noqa: SIM115 - frames are read from it for as long as somebody asks
        return cls(path, file, written_index(file))

    def static(self, name: str) -> Any:
        """A field that holds for all frames, whole: text, an array, or the bytes of a colour image."""
        entity, component = place(name)
        kept = self.layout.static[name]
        lists = self._last(entity, component)
        if lists is None:
            raise Refusal(f"{name} is missing")
        if component == META:
            value = lists.flatten()[0].as_py()
        elif name == "rgb":
            value = byte_strings(lists)[0]
        else:
            value = numbers(lists, component, kept.dtype, kept.shape)[0]
        if checksum(value) != kept.crc32:
            raise Refusal(f"{name} does not match its checksum")
        return value

    def moving(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """A field of every frame: values (n, ...), and where they are there, once and undamaged, (n,) bool."""
        kept = self.layout.frames[name]
        if name == "counts":
            zones = range(kept.shape[0])
            parts = [self._gather(self.layout.zone_entity(p), COUNTS, kept.dtype, kept.shape[1:]) for p in zones]
            values, there = np.stack([v for v, _ in parts], axis=1), np.all([t for _, t in parts], axis=0)
        else:
            values, there = self._gather(*place(name), kept.dtype, kept.shape)
        return values, there & self._match(name, values)

    def image(self, name: str, frame: int) -> bytes:
        """The bytes of an image: encoded where it is colour, else of its pixels."""
        value = self._images[name].at(frame)
        if value is None:
            raise Refusal(f"{name}[{frame}] is missing")
        if checksum(value) != self._sum(name, int(np.searchsorted(self.frames, frame))):
            raise Refusal(f"{name}[{frame}] does not match its checksum")
        return value

    def covers(self, name: str) -> bool:
        """Whether the index has a place for every image of a field; the images are not read."""
        return self._images[name].cover(len(self.frames))

    def complete(self) -> np.ndarray:
        """(n,) where every field of a frame is there and undamaged; reads all of the file."""
        good = np.ones(len(self.frames), bool)
        for name in self.layout.frames:
            good &= self._whole_images(name) if name in IMAGES else self.moving(name)[1]
        return good

    def _whole_images(self, name: str) -> np.ndarray:
        sums = {int(frame): self._sum(name, i) for i, frame in enumerate(self.frames)}
        every = self._images[name].every()
        return np.isin(self.frames, [frame for frame, value in every if checksum(value) == sums.get(frame)])

    def _sum(self, name: str, i: int) -> int:
        return int(self._sums[i, list(self.layout.frames).index(name)])

    def _match(self, name: str, values: np.ndarray) -> np.ndarray:
        return np.array([checksum(value) == self._sum(name, i) for i, value in enumerate(values)])

    def _gather(
        self, entity: str, component: str, dtype: np.dtype, shape: tuple[int, ...]
    ) -> tuple[np.ndarray, np.ndarray]:
        # The rows are looked at before room is made for all, so that memory follows what the file holds.
        pieces = [(frames, numbers(lists, component, dtype, shape)) for frames, lists in self._rows(entity, component)]
        if not pieces:
            raise Refusal(f"{entity} {component} is missing")
        values = np.zeros((len(self.frames), *shape), dtype)
        times = np.zeros(len(self.frames), int)
        for frames, rows in pieces:
            known = np.isin(frames, self.frames)
            at = np.searchsorted(self.frames, frames[known])
            values[at] = rows[known]
            np.add.at(times, at, 1)
        return values, times == 1

    def _rows(self, entity: str, component: str) -> Iterator[tuple[np.ndarray, pa.ListArray]]:
        for there in self._moving[entity]:
            found = column(there.read(self._file), component)
            if found is not None:
                yield found

    def _last(self, entity: str, component: str) -> pa.ListArray | None:
        for there in reversed(self._still[entity]):
            found = column(there.read(self._file), component)
            if found is not None and len(found[1]):
                return found[1][-1:]
        return None

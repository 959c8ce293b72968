"""The images of one field in an .rrd file, read chunk by chunk as they are asked for."""

import threading
from collections import OrderedDict
from collections.abc import Iterator, Sequence
from typing import BinaryIO

import numpy as np

from recordings.rrd.arrays import byte_strings, column
from recordings.rrd.index import ChunkPlace

# Chunks kept at hand: frames are mostly asked for one after another, and a chunk holds some.
RECENT_CHUNKS = 3


class RrdImages:
    """Images under `component` in the chunks at `places` of a file; may be asked from several threads."""

    def __init__(self, file: BinaryIO, component: str, places: Sequence[ChunkPlace]) -> None:
        self._file = file
        self._component = component
        self._places = places
        self._first = np.array([there.first for there in places], np.int64)
        self._last = np.array([there.last for there in places], np.int64)
        self._recent: OrderedDict[int, dict[int, bytes]] = OrderedDict()
        self._looking = threading.Lock()

    def at(self, frame: int) -> bytes | None:
        """The bytes of the image of a frame: encoded where it is colour, else of its pixels; None if missing."""
        for i in np.flatnonzero((self._first <= frame) & (frame <= self._last)):
            value = self._chunk(int(i)).get(frame)
            if value is not None:
                return value
        return None

    def every(self) -> Iterator[tuple[int, bytes]]:
        """Frame and bytes of all images, chunk by chunk."""
        for there in self._places:
            yield from self._read(there).items()

    def cover(self, frames: int) -> bool:
        """Whether the index has a place for each of the frames 0 to `frames` - 1; nothing is read."""
        reach = 0
        for i in np.argsort(self._first, kind="stable"):
            if self._first[i] > reach:
                return False
            reach = max(reach, int(self._last[i]) + 1)
        return reach >= frames

    def _chunk(self, i: int) -> dict[int, bytes]:
        with self._looking:
            if i not in self._recent:
                self._recent[i] = self._read(self._places[i])
                if len(self._recent) > RECENT_CHUNKS:
                    self._recent.popitem(last=False)
            return self._recent[i]

    def _read(self, there: ChunkPlace) -> dict[int, bytes]:
        found = column(there.read(self._file), self._component)
        return {} if found is None else dict(zip(found[0].tolist(), byte_strings(found[1]), strict=True))

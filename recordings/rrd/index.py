"""Where in an .rrd file which frames of which entity are."""

import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import BinaryIO

from recordings.refusal import Refusal
from recordings.rrd.container import DATA, END, RECORDING_STORE, Chunk, batch, chunk, messages, payload, protobuf

# The last bytes of a finished file: u64 offset and u64 length of the index, u32 checksum, the tag, u32 count.
TAIL_BYTES = 32
TAIL_TAG = b"RRF2FOOT"
FRAME = "frame"


@dataclass(frozen=True)
class ChunkPlace:
    """A chunk by its place in the file: offset and length in bytes, first and last frame (0, -1 if static)."""

    entity: str
    static: bool
    offset: int
    length: int
    first: int
    last: int

    def read(self, file: BinaryIO) -> Chunk:
        """The chunk itself; refuses one that is not what the index says."""
        found = chunk(payload(file, self.offset, self.length))
        if found is None or found.entity != self.entity or found.static != self.static:
            raise Refusal(f"the chunk at byte {self.offset} is not of {self.entity}, as the index says")
        return found


def written_index(file: BinaryIO) -> list[ChunkPlace]:
    """The index that a finished file carries at its end; refuses a file that ends without one."""
    size = os.fstat(file.fileno()).st_size
    tail = os.pread(file.fileno(), TAIL_BYTES, max(0, size - TAIL_BYTES))
    if tail[20:28] != TAIL_TAG:
        raise Refusal(f"is cut off after {size} bytes, before its index; `difflidar repair` saves what is whole")
    offset, length = int.from_bytes(tail[:8], "little"), int.from_bytes(tail[8:16], "little")
    return [place for part in protobuf(payload(file, offset, length)) for place in places(part[1])]


def places(manifest: bytes) -> Iterator[ChunkPlace]:
    """The chunks that one manifest lists; none where it is that of a blueprint."""
    parts = dict(protobuf(manifest))
    if dict(protobuf(parts[1])).get(1) != RECORDING_STORE:
        return
    table = dict(protobuf(parts[4]))
    rows = batch(table[2], table.get(3, 0), table.get(4, 0))
    # A chunk without rows of the timeline has no first frame; static chunks have none.
    ends = [
        rows[f"{FRAME}:{end}"].fill_null(0 if end == "start" else -1).to_pylist()
        if f"{FRAME}:{end}" in rows.schema.names
        else [0 if end == "start" else -1] * rows.num_rows
        for end in ("start", "end")
    ]
    columns = ("chunk_entity_path", "chunk_is_static", "chunk_byte_offset", "chunk_byte_size")
    for entity, static, offset, length, first, last in zip(
        *(rows[name].to_pylist() for name in columns), *ends, strict=True
    ):
        yield ChunkPlace(entity.strip("/"), static, offset, length, first, last)


def found_index(file: BinaryIO) -> tuple[list[ChunkPlace], int, int]:
    """The index found by reading every whole message of a file that may be cut off or damaged.

    Returns the places, how many data messages could not be read, and after how many bytes the last whole
    message ends.
    """
    found, damaged, end = [], 0, 0
    size = os.fstat(file.fileno()).st_size
    for message in messages(file):
        # After the last message of a finished file stand only the bytes that say where it is.
        end = message.offset + message.length if message.kind != END else size
        if message.kind != DATA:
            continue
        try:
            here = chunk(payload(file, message.offset, message.length))
            if here is not None:
                found.append(ChunkPlace(here.entity, here.static, message.offset, message.length, *span(here)))
        except Exception:  # whatever a decoder says of damaged bytes, the message is lost
            damaged += 1
    return found, damaged, end


def span(here: Chunk) -> tuple[int, int]:
    """First and last frame of a chunk; 0, -1 where it is of no frame."""
    if here.static or FRAME not in here.rows.schema.names or here.rows.num_rows == 0:
        return 0, -1
    frames = here.rows[FRAME].to_numpy(zero_copy_only=False)
    return int(frames.min()), int(frames.max())

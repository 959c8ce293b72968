"""The frame around the data in an .rrd file: messages, and the chunk of rows inside each.

Layout (rerun 0.2x to 0.41, "RRF2"): a 12-byte header, then messages, each u64 kind, u64 length (little endian)
and a protobuf payload; a message of kind END closes the file and carries an index of its chunks. A data message
holds one Arrow record batch as an LZ4-compressed IPC stream.

It is read here, not by the rerun library, for three reasons found by test: the library ends the whole process
on some damaged files, it reads no single chunk by its place, and it reads no file without its last message.
"""

import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import BinaryIO

import pyarrow as pa

from recordings.refusal import Refusal

MAGIC = b"RRF2"
HEADER_BYTES = 12
PREFIX_BYTES = 16
END, DATA, LAST_KIND = 0, 2, 3
RECORDING_STORE = 1
LZ4 = 2
# An LZ4 block grows by at most this on decompression; a larger claim is a lie.
LZ4_MOST = 255
# No message of ours is larger, and Arrow's 32-bit offsets allow no more.
MOST_BYTES = 1 << 31


@dataclass(frozen=True)
class Message:
    """A message by its place: kind, and offset and length of its payload in bytes."""

    kind: int
    offset: int
    length: int


@dataclass(frozen=True)
class Chunk:
    """Rows of one entity: its path, whether they hold for all time, and the batch of columns."""

    entity: str
    static: bool
    rows: pa.RecordBatch


def messages(file: BinaryIO) -> Iterator[Message]:
    """The whole messages from the start of the file, up to END or to the first that is not whole."""
    size = os.fstat(file.fileno()).st_size
    head = os.pread(file.fileno(), HEADER_BYTES, 0)
    if head[:4] != MAGIC or len(head) < HEADER_BYTES:
        raise Refusal(f"starts with {head[:4]!r}, expected {MAGIC!r} of an .rrd file")
    offset = HEADER_BYTES
    while offset + PREFIX_BYTES <= size:
        prefix = os.pread(file.fileno(), PREFIX_BYTES, offset)
        kind = int.from_bytes(prefix[:8], "little")
        length = int.from_bytes(prefix[8:], "little")
        offset += PREFIX_BYTES
        if kind > LAST_KIND or offset + length > size:
            return
        yield Message(kind, offset, length)
        if kind == END:
            return
        offset += length


def payload(file: BinaryIO, offset: int, length: int) -> bytes:
    """The bytes of one message; refuses a place outside the file."""
    if not 0 <= length <= MOST_BYTES or offset < HEADER_BYTES:
        raise Refusal(f"a message of {length} bytes at byte {offset}, expected one inside the file")
    data = os.pread(file.fileno(), length, offset)
    if len(data) != length:
        raise Refusal(f"ends inside the message at byte {offset}, expected {length} bytes of it")
    return data


def chunk(data: bytes) -> Chunk | None:
    """The chunk in a data message of a recording; None for one of a blueprint."""
    parts = dict(protobuf(data))
    if dict(protobuf(parts[1])).get(1) != RECORDING_STORE:
        return None
    rows = batch(parts[5], parts.get(2, 0), parts.get(3, 0))
    entity = rows.schema.metadata[b"rerun:entity_path"].decode()
    return Chunk(entity.strip("/"), bool(parts.get(7, 0)), rows)


def batch(data: bytes, compression: int, size: int) -> pa.RecordBatch:
    """One Arrow record batch from its IPC stream, checked through and through before it is used."""
    if compression == LZ4:
        if size > min(LZ4_MOST * len(data), MOST_BYTES):
            raise Refusal(f"{len(data)} compressed bytes claim to hold {size}")
        data = pa.decompress(data, decompressed_size=size, codec="lz4_raw")
    with pa.ipc.open_stream(data) as stream:
        rows = stream.read_next_batch()
    rows.validate(full=True)
    return rows


def protobuf(data: bytes) -> Iterator[tuple[int, int | bytes]]:
    """The fields of a protobuf message: number, and integer or bytes (a string or an inner message)."""
    at = 0
    while at < len(data):
        tag, at = varint(data, at)
        number, wire = tag >> 3, tag & 7
        if wire == 0:
            value, at = varint(data, at)
            yield number, value
        elif wire == 2:
            length, at = varint(data, at)
            if at + length > len(data):
                raise Refusal("a field ends outside its message")
            yield number, data[at : at + length]
            at += length
        elif wire in (1, 5):
            at += 8 if wire == 1 else 4
        else:
            raise Refusal(f"wire type {wire}, expected one of protobuf")


def varint(data: bytes, at: int) -> tuple[int, int]:
    """A variable-length integer and where the next field starts."""
    value = 0
    for i in range(10):
        byte = data[at + i]
        value |= (byte & 127) << 7 * i
        if byte < 128:
            return value, at + i + 1
    raise Refusal("an integer of more than 64 bits")

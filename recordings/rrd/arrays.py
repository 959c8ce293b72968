"""Arrays of numbers and bytes to the Arrow columns of an .rrd file and back, bit for bit."""

from collections.abc import Sequence

import numpy as np
import pyarrow as pa

from recordings.refusal import Refusal
from recordings.rrd.container import Chunk
from recordings.rrd.index import FRAME
from recordings.rrd.layout import COUNTS


class Batch:
    """An Arrow array where the rerun library wants a batch of components."""

    def __init__(self, array: pa.Array) -> None:
        self._array = array

    def as_arrow_array(self) -> pa.Array:
        """The array itself."""
        return self._array


def rows_of_numbers(values: np.ndarray, kind: pa.ListType | None = None) -> pa.ListArray:
    """(n, ...) numbers as n lists, without a copy; of Arrow type `kind` where that is given."""
    flat = np.ascontiguousarray(values).reshape(len(values), -1)
    starts = pa.array(np.arange(len(flat) + 1, dtype=np.int32) * np.int32(flat.shape[1]))
    return pa.ListArray.from_arrays(starts, pa.array(flat.reshape(-1)), type=kind)


def rows_of_bytes(blobs: Sequence[bytes], kind: pa.ListType) -> pa.ListArray:
    """n byte strings as n lists of uint8."""
    starts = np.cumsum([0, *map(len, blobs)], dtype=np.int32)
    return pa.ListArray.from_arrays(pa.array(starts), pa.array(np.frombuffer(b"".join(blobs), np.uint8)), type=kind)


def tensors(values: np.ndarray, kind: pa.StructType) -> pa.StructArray:
    """(n, T) unsigned integers as n one-dimensional tensors of the viewer's type `kind`, made as a whole.

    Row by row through the library the same takes a hundred times as long.
    """
    n, bins = values.shape
    union = kind.field("buffer").type
    tags = [union.field(i).name for i in range(union.num_fields)]
    tag = tags.index(f"U{values.dtype.itemsize * 8}")
    children = [pa.array([], union.field(i).type) for i in range(union.num_fields)]
    children[tag] = rows_of_numbers(values, union.field(tag).type)
    codes, offsets = np.full(n, tag, np.int8), np.arange(n, dtype=np.int32)
    buffers = [None, pa.py_buffer(codes), pa.py_buffer(offsets)]
    buffer = pa.Array.from_buffers(union, n, buffers, children=children)
    shape = rows_of_numbers(np.full((n, 1), bins, np.uint64), kind.field("shape").type)
    names = pa.nulls(n, kind.field("names").type)
    return pa.StructArray.from_arrays([shape, names, buffer], fields=[kind.field(i) for i in range(3)])


def column(chunk: Chunk, component: str) -> tuple[np.ndarray | None, pa.ListArray] | None:
    """Frames (None where static) and lists of the rows in which a chunk has `component`; None if in no frame."""
    if component not in chunk.rows.schema.names or (not chunk.static and FRAME not in chunk.rows.schema.names):
        return None
    lists = chunk.rows[component]
    if not pa.types.is_list(lists.type):
        raise Refusal(f"{chunk.entity} {component} is of type {lists.type}, expected lists")
    there = lists.is_valid()
    lists = lists.filter(there) if lists.null_count else lists
    if chunk.static:
        return None, lists
    frames = chunk.rows[FRAME].to_numpy(zero_copy_only=False)
    return frames[there.to_numpy(zero_copy_only=False)], lists


def numbers(lists: pa.ListArray, component: str, dtype: np.dtype, shape: tuple[int, ...]) -> np.ndarray:
    """(n, *shape) numbers from n lists; refuses rows of another type or length."""
    items = lists.flatten()
    if component == COUNTS:
        items = tensor_items(items, dtype)
    images = pa.types.is_list(items.type)
    flat = (items.flatten() if images else items).to_numpy(zero_copy_only=True)
    # Images are kept as the bytes of their pixels.
    flat = flat.view(dtype) if images else flat
    wanted = len(lists) * int(np.prod(shape, dtype=object))
    if flat.dtype != dtype or flat.size != wanted:
        there = f"{flat.size} values of {flat.dtype.name}"
        raise Refusal(f"{component} has {there} in {len(lists)} rows, expected {wanted} of {dtype.name}")
    return flat.reshape(len(lists), *shape)


def tensor_items(tensor: pa.StructArray, dtype: np.dtype) -> pa.Array:
    """The values of tensors that are all of one type."""
    buffer = tensor.field("buffer")
    codes = np.unique(buffer.type_codes.to_numpy())
    tags = [buffer.type.field(int(code)).name for code in codes]
    if tags != [f"U{dtype.itemsize * 8}"]:
        raise Refusal(f"counts are of {', '.join(tags) or 'no'} type, expected {dtype.name}")
    return buffer.field(int(codes[0])).take(buffer.offsets).flatten()


def byte_strings(lists: pa.ListArray) -> list[bytes]:
    """The byte string of each row."""
    inner = lists.flatten()
    if len(inner) != len(lists):
        raise Refusal(f"{len(inner)} images in {len(lists)} rows, expected one in each")
    flat = inner.flatten().to_numpy(zero_copy_only=True)
    ends = np.cumsum(inner.value_lengths().to_numpy(zero_copy_only=True))
    return [flat[end - n : end].tobytes() for end, n in zip(ends, np.diff(ends, prepend=0), strict=True)]

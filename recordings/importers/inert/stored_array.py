"""An array whose header is read and checked, and whose bytes still lie in the file."""

from dataclasses import dataclass
from math import prod
from typing import Any, BinaryIO

import numpy as np

from recordings.importers.inert.reader import Span
from recordings.refusal import Refusal

ARRAY_LIMIT_BYTES = 256 << 20


@dataclass(frozen=True)
class StoredArray:
    """An array of `shape` and `dtype` whose bytes may still lie in the file; `order` is C or F."""

    shape: tuple[int, ...]
    dtype: np.dtype
    order: str
    payload: bytes | Span

    def read(self, file: BinaryIO) -> np.ndarray:
        """The array itself, read-only."""
        if 0 in self.shape:
            return np.empty(self.shape, self.dtype)
        payload = self.payload
        if isinstance(payload, Span):
            file.seek(payload.offset)
            payload = file.read(payload.length)
            if len(payload) < self.payload.length:
                raise Refusal(f"{file.name} became shorter while it was read")
        return np.frombuffer(payload, self.dtype).reshape(self.shape, order=self.order)


def stored(shape: Any, dtype: Any, order: Any, payload: Any) -> StoredArray:
    """A stored array whose header agrees with the bytes behind it."""
    sound = isinstance(shape, tuple) and all(type(n) is int and n >= 0 for n in shape) and order in ("C", "F")
    if not sound or not isinstance(dtype, np.dtype):
        raise Refusal("has an array whose header is none")
    if not isinstance(payload, bytes | bytearray | Span):
        raise Refusal(f"has an array of {dtype.name} without its bytes, expected plain numbers")
    claimed = prod(shape) * dtype.itemsize
    if claimed != len(payload):
        raise Refusal(f"has an array of shape {shape}, which is {claimed} bytes, but {len(payload)} of them")
    if claimed > ARRAY_LIMIT_BYTES:
        raise Refusal(f"has an array of {claimed} bytes, expected at most {ARRAY_LIMIT_BYTES}")
    return StoredArray(shape, dtype, order, payload)

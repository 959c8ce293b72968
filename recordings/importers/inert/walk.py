"""Walks through revived records: their arrays by name, loaded, and as plain JSON."""

import math
from collections.abc import Iterator
from typing import Any, BinaryIO

import numpy as np

from recordings.importers.inert.makers import StandIn
from recordings.importers.inert.stored_array import StoredArray

LOADED_LIMIT_BYTES = 4 << 20
# Python refuses to write very long integers as text.
INTEGER_BITS = 64


def named(key: Any) -> str:
    """A dictionary's key, or another short value, in words."""
    if isinstance(key, str | float | StandIn) or (isinstance(key, int) and key.bit_length() <= INTEGER_BITS):
        return str(key)
    return type(key).__name__


def arrays_in(value: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[str, StoredArray]]:
    """Every array in nested dictionaries with its dotted path."""
    if isinstance(value, StoredArray):
        yield ".".join(path), value
    elif isinstance(value, dict):
        for key, item in value.items():
            yield from arrays_in(item, (*path, named(key)))


def loaded(value: Any, file: BinaryIO) -> Any:
    """`value` with its stored arrays read from the file, as long as they are small together."""
    left = LOADED_LIMIT_BYTES

    def load(value: Any) -> Any:
        nonlocal left
        if isinstance(value, StoredArray):
            left -= len(value.payload)
            return value.read(file) if left >= 0 else value
        if isinstance(value, dict):
            return {key: load(item) for key, item in value.items()}
        return [load(item) for item in value] if isinstance(value, list | tuple) else value

    return load(value)


def as_json(value: Any) -> Any:
    """`value` in plain JSON: arrays as lists, everything JSON does not know as text, NaN and infinity too."""
    if isinstance(value, dict):
        return {named(key): as_json(item) for key, item in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [as_json(item) for item in value]
    if isinstance(value, np.ndarray):
        return as_json(value.tolist())
    if isinstance(value, int) and value.bit_length() > INTEGER_BITS:
        return hex(value)
    if value is None or isinstance(value, bool | int | str) or (isinstance(value, float) and math.isfinite(value)):
        return value
    return str(value) if isinstance(value, float | complex | StandIn) else type(value).__name__

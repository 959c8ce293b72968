"""Check one array against its field: type, shape, values."""

from typing import Any

import numpy as np

from recordings.fields import BYTES_ONLY, Field
from recordings.refusal import Refusal

# Values are looked at in blocks of about this many, so that a check needs little memory beside the array.
BLOCK_VALUES = 1 << 22
KINDS = {"u": "integers", "i": "integers", "f": "floating-point numbers"}


def checked(name: str, value: Any, field: Field, sizes: dict[str, int], frame: int | None = None) -> Any:
    """`value` as a plain array of the field's type, shape and values; `sizes` learns the axes it shows.

    Numbers keep their values and their type (byte order aside). Frames that are read on demand (they have a
    shape and a dtype, but are no array) are checked for those here and for their values when they are read.
    `frame` is the index at which `value` stands in the whole array, for the sentence.
    """
    if value is None:
        raise Refusal(f"{name} is missing, expected {field.expected} of shape {written(field.shapes)}")
    if not isinstance(value, np.ndarray) and hasattr(value, "dtype") and len(getattr(value, "shape", ())) > 1:
        check_type(name, value.dtype, field)
        check_shape(name, value.shape, field.shapes, sizes)
        return value
    try:
        array = np.asarray(value)
    except (ValueError, TypeError):
        raise Refusal(f"{name} is not an array of equal rows, expected {field.expected}") from None
    check_type(name, array.dtype, field)
    check_shape(name, array.shape, field.shapes, sizes)
    array = array.astype(array.dtype.newbyteorder("="), copy=False)
    if field.good is not None:
        check_values(name, array, field, frame)
    return array


def check_type(name: str, dtype: np.dtype, field: Field) -> None:
    """Refuse other types of number than the field's."""
    if name in BYTES_ONLY and dtype != np.uint8:
        raise Refusal(f"{name} holds {dtype.name}, expected uint8")
    if dtype.kind not in field.kinds or dtype.itemsize > 8:
        expected = " or ".join(dict.fromkeys(KINDS[kind] for kind in field.kinds))
        raise Refusal(f"{name} holds {dtype.name}, expected {expected} of at most 64 bits")


def check_shape(name: str, shape: tuple[int, ...], shapes: tuple[str, ...], sizes: dict[str, int]) -> None:
    """Refuse a shape that is none of `shapes`; lengths of axes not seen before are added to `sizes`."""
    for letters in shapes:
        wanted = [int(c) if c.isdigit() else sizes.get(c) for c in letters]
        if len(wanted) == len(shape) and all(n > 0 and w in (n, None) for w, n in zip(wanted, shape, strict=True)):
            sizes.update({c: n for c, n in zip(letters, shape, strict=True) if not c.isdigit()})
            return
    known = [f"{c}={sizes[c]}" for c in sorted(set("".join(shapes))) if c in sizes]
    where = f", {', '.join(known)}" if known else ""
    raise Refusal(f"{name} has shape {tuple(shape)}, expected {written(shapes)}{where} and no axis empty")


def written(shapes: tuple[str, ...]) -> str:
    """Shapes as a person writes them: (F, P, T) or (P,)."""
    return " or ".join(f"({', '.join(s)}{',' if len(s) == 1 else ''})" for s in shapes)


def check_values(name: str, array: np.ndarray, field: Field, frame: int | None = None) -> None:
    """Refuse the first value that is not admitted, naming its index."""
    rows = array.reshape(-1)
    for start in range(0, rows.size, BLOCK_VALUES):
        good = field.good(rows[start : start + BLOCK_VALUES])
        if not good.all():
            flat = start + int(np.argmin(good))
            index = (() if frame is None else (frame,)) + np.unravel_index(flat, array.shape)
            place = f"[{', '.join(str(int(i)) for i in index)}]" if index else ""
            raise Refusal(f"{name}{place} is {rows[flat]}, expected {field.expected}")

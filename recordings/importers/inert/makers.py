"""What each admitted call of a pickle stands for, worked out from its arguments alone."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from recordings.importers.inert.stored_array import StoredArray, stored
from recordings.importers.inert.unpickler import PUBLISHERS
from recordings.refusal import Refusal

NUMBER_OR_TEXT = re.compile(r"[<>|=]?[biufcSU]\d{1,9}")


@dataclass(frozen=True, eq=False)
class StandIn:
    """An object of the publisher's own package, known by its name and what it was made from."""

    name: str
    args: tuple[Any, ...]
    state: Any = None

    def __str__(self) -> str:
        plain = (type(one) is str or (type(one) is int and one.bit_length() <= 64) for one in self.args)
        shown = (str(one) if ok else type(one).__name__ for one, ok in zip(self.args, plain, strict=True))
        return f"{self.name}({', '.join(shown)})"


def array(args: tuple[Any, ...], state: Any) -> StoredArray:
    """numpy's `_reconstruct` followed by its state: version, shape, dtype, Fortran order, bytes."""
    *_, shape, dtype, fortran, payload = state
    return stored(shape, dtype, "F" if fortran else "C", payload)


def array_from_buffer(args: tuple[Any, ...], state: Any) -> StoredArray:
    """numpy's `_frombuffer`, as pickle protocol 5 writes arrays."""
    payload, dtype, shape, order = args
    return stored(shape, dtype, order, payload)


def scalar(args: tuple[Any, ...], state: Any) -> Any:
    """numpy's `scalar`: dtype and bytes."""
    dtype, payload = args
    return np.frombuffer(payload, stored((), dtype, "C", payload).dtype)[0].item()


def dtype(args: tuple[Any, ...], state: Any) -> np.dtype:
    """A dtype of numbers or text; structured and object types are refused."""
    if not (isinstance(args[0], str) and NUMBER_OR_TEXT.fullmatch(args[0])):
        raise Refusal(f"has an array of type {args[0]!r:.40}, expected plain numbers")
    if state is not None and any(part is not None for part in state[2:5]):
        raise Refusal("has a structured array, expected plain numbers")
    made = np.dtype(args[0])
    return made.newbyteorder(state[1]) if state is not None and state[1] in ("<", ">") else made


def encoded(args: tuple[Any, ...], state: Any) -> bytes:
    """Bytes as pickle protocols below 3 write them: text of Latin-1."""
    text, encoding = args
    if encoding not in ("latin1", "latin-1"):
        raise Refusal(f"has bytes in the encoding {encoding!r:.40}, expected latin1")
    return text.encode("latin-1")


def number(args: tuple[Any, ...], state: Any) -> complex:
    """A complex number from its two parts."""
    return complex(*(float(part) for part in args))


def octets(args: tuple[Any, ...], state: Any) -> bytes:
    """Bytes or a bytearray from nothing or bytes; from a number they would be memory for the asking."""
    return b"".join(part if isinstance(part, bytes) else part.encode("latin-1") for part in args[:1])


def member(args: tuple[Any, ...], state: Any) -> StandIn:
    """A member of a publisher's enum by its name, as some versions of Python write it."""
    owner, name = args
    if not (isinstance(owner, StandIn) and owner.name.split(".")[0] in PUBLISHERS and type(name) is str):
        raise Refusal("asks for builtins.getattr, expected numpy arrays and plain containers only")
    return StandIn(owner.name, (name,))


MAKERS: dict[str, Callable[[tuple[Any, ...], Any], Any]] = {
    "_reconstruct": array,
    "_frombuffer": array_from_buffer,
    "scalar": scalar,
    "dtype": dtype,
    "encode": encoded,
    "complex": number,
    "bytes": octets,
    "bytearray": octets,
    "getattr": member,
}

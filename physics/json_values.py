"""Values out of JSON that a person wrote: each is what is expected, or one sentence names its place."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from recordings.refusal import Refusal


def an_object(said: Any, fields: Mapping[str, bool], place: str) -> dict[str, Any]:
    """An object with these fields, name -> whether it must be there, and no others."""
    if not isinstance(said, dict):
        raise Refusal(f"{place} is {_kind(said)}, expected an object with {', '.join(fields)}")
    for name in said:
        if name not in fields:
            raise Refusal(f"{place} has the unknown field {name!r}, expected one of {', '.join(fields)}")
    for name, required in fields.items():
        if required and name not in said:
            raise Refusal(f"{place} lacks {name}, expected {', '.join(n for n, r in fields.items() if r)}")
    return said


def a_list(said: Any, place: str, length: int | None = None) -> list[Any]:
    """A list, of this length if given."""
    if not isinstance(said, list) or (length is not None and len(said) != length):
        many = "a list" if length is None else f"a list of {length}"
        raise Refusal(f"{place} is {_kind(said)}, expected {many}")
    return said


def a_text(said: Any, place: str) -> str:
    """A text."""
    if not isinstance(said, str):
        raise Refusal(f"{place} is {_kind(said)}, expected a text")
    return said


def a_number(said: Any, place: str) -> float:
    """A finite number."""
    if isinstance(said, bool) or not isinstance(said, int | float) or not math.isfinite(said):
        raise Refusal(f"{place} is {said if isinstance(said, int | float) else _kind(said)}, expected a finite number")
    return float(said)


def a_whole_number(said: Any, place: str) -> int:
    """A whole number."""
    number = a_number(said, place)
    if number != int(number):
        raise Refusal(f"{place} is {number:g}, expected a whole number")
    return int(number)


def numbers(said: Any, place: str, length: int | None = None) -> np.ndarray:
    """(N,) finite numbers, N = `length` if given."""
    return np.array([a_number(item, f"{place}[{i}]") for i, item in enumerate(a_list(said, place, length))], float)


def one_or_more(said: Any, place: str) -> float | np.ndarray:
    """A finite number, or a list of them."""
    return numbers(said, place) if isinstance(said, list) else a_number(said, place)


def _kind(said: Any) -> str:
    """What was found, in a word or two."""
    if isinstance(said, list):
        return f"a list of {len(said)}"
    return {dict: "an object", str: f"the text {str(said)[:40]!r}", bool: f"{said}".lower(), type(None): "null"}.get(
        type(said), f"{said}"
    )

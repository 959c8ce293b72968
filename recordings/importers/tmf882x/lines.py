"""One line of a TMF882x's serial output, and what it says; strictly, so that a damaged line is known as one.

Formats after the makers' Arduino driver 1.14: `#Raw,address,index` and 128 bytes of a histogram (`#Cal` of the
electrical calibration), `#Obj,address,number,temperature,valid,tick` and 36 pairs of distance and confidence. Numbers
are decimal and not padded, so a field has one spelling for each value, and a table of those spellings is both the
strictest and the fastest way to read it. The UW Graphics firmware prints the same lines; its `#Obj` may stand alone,
and its `#Prt` says how many bins it left out, then the bytes of the others.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

BINS = 128
PLANES = 3
CHANNELS = 10
LINES = PLANES * CHANNELS
RECORDS = 36
TICKS = 1 << 32

BYTES = {b"%d" % n: n for n in range(256)}
WORDS = {b"%d" % n: n for n in range(1 << 16)}
KINDS = {b"#Raw": "Raw", b"#Cal": "Cal", b"#Prt": "Prt"}
PREFIXES = (*KINDS, b"#Obj")


@dataclass(frozen=True, eq=False)
class RawLine:
    """One byte of each bin of a channel: index is 10 x plane + channel, plane 0 the least significant.

    values: (128,) uint8. skipped: how many of the first bins `#Prt` left out; they hold 0 here.
    """

    kind: Literal["Raw", "Cal", "Prt"]
    address: int
    index: int
    values: np.ndarray
    skipped: int = 0


@dataclass(frozen=True, eq=False)
class ObjLine:
    """What the chip found, in 36 records: zones 1 to 9, 10 to 18, then the second object of each.

    number: of the result, 0 to 255. temperature_c: signed. valid: how many records hold something. tick: the chip's
    counter, 0 to 2^32 - 1. distance_mm: (36,) uint16. confidence: (36,) uint8.
    """

    address: int
    number: int
    temperature_c: int
    valid: int
    tick: int
    distance_mm: np.ndarray
    confidence: np.ndarray


@dataclass(frozen=True)
class BareObj:
    """`#Obj` and nothing else: the end of a measurement that says nothing of itself."""


@dataclass(frozen=True)
class TextLine:
    """Any other printable line: states, `#Conf`, `#Err`, help, other programs."""

    text: str


@dataclass(frozen=True)
class Damaged:
    """A line that begins as data and is none, or is not text; `why` says the kind, a comma, the thing."""

    why: str


Line = RawLine | ObjLine | BareObj | TextLine | Damaged


def parse(line: bytes) -> Line:
    """What a line without its newline says; a carriage return at its end, as terminals write it, is none of it."""
    line = line.removesuffix(b"\r")
    if line[:4] in PREFIXES:
        fields = line.split(b",")
        try:
            return obj_line(fields) if fields[0] == b"#Obj" else raw_line(fields)
        except KeyError as wrong:
            return Damaged(f"a number does not belong there, {shown(wrong.args[0])}")
        except ValueError as wrong:
            return Damaged(str(wrong))
    if line.isascii() and (text := line.decode("ascii").replace("\t", " ")).isprintable():
        return TextLine(text)
    return Damaged("not text")


def raw_line(fields: list[bytes]) -> RawLine:
    """A line of a histogram; `KeyError` of the field, or `ValueError`, where it is none."""
    kind = KINDS.get(fields[0])
    partial = kind == "Prt" and len(fields) > 3
    skipped = BYTES[fields[3]] if partial else 0
    before = 4 if partial else 3
    if kind is None or skipped >= BINS or len(fields) != before + BINS - skipped:
        raise ValueError(f"a wrong number of fields, {len(fields)} with {shown(fields[0])}")
    index = BYTES[fields[2]]
    if index >= LINES:
        raise ValueError(f"an index above {LINES - 1}, {index}")
    values = bytes(skipped) + bytes(map(BYTES.__getitem__, fields[before:]))
    return RawLine(kind, address(fields), index, np.frombuffer(values, np.uint8), skipped)


def obj_line(fields: list[bytes]) -> ObjLine | BareObj:
    """A line of results; `KeyError` of the field, or `ValueError`, where it is none."""
    if len(fields) == 1:
        return BareObj()
    if len(fields) != 6 + 2 * RECORDS:
        raise ValueError(f"a wrong number of fields, {len(fields)} with '#Obj'")
    temperature, valid = BYTES[fields[3]], BYTES[fields[4]]
    return ObjLine(
        address(fields),
        BYTES[fields[2]],
        # The firmware prints the signed byte of the register as an unsigned one.
        temperature - 256 if temperature > 127 else temperature,
        valid,
        counter(fields[5]),
        np.array([WORDS[one] for one in fields[6::2]], np.uint16),
        np.frombuffer(bytes(map(BYTES.__getitem__, fields[7::2])), np.uint8),
    )


def address(fields: list[bytes]) -> int:
    """The chip's I2C address, of 7 bits."""
    value = BYTES[fields[1]]
    if value > 127:
        raise ValueError(f"an address above 127, {value}")
    return value


def counter(field: bytes) -> int:
    """32 bits that are printed as a signed number."""
    digits = field.removeprefix(b"-")
    if not (digits.isdigit() and len(digits) <= 10):
        raise KeyError(field)
    value = int(field)
    if b"%d" % value != field or not -TICKS // 2 <= value < TICKS // 2:
        raise KeyError(field)
    return value % TICKS


def shown(field: bytes) -> str:
    """A field as a sentence can hold it."""
    return ascii(field[:12].decode("latin-1"))

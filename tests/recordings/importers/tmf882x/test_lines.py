"""One line: everything the firmware can print is read as it was meant, everything else is known not to be."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from recordings.importers.tmf882x.lines import BareObj, Damaged, ObjLine, RawLine, TextLine, parse

BYTES = st.lists(st.integers(0, 255), min_size=128, max_size=128)


@given(kind=st.sampled_from(["Raw", "Cal"]), address=st.integers(0, 127), index=st.integers(0, 29), values=BYTES)
def test_a_histogram_line_is_read_back(kind, address, index, values):
    line = parse(f"#{kind},{address},{index},{','.join(map(str, values))}".encode())
    assert isinstance(line, RawLine)
    assert (line.kind, line.address, line.index, line.values.tolist()) == (kind, address, index, values)
    assert line.values.dtype == np.uint8


@given(
    number=st.integers(0, 255),
    celsius=st.integers(-128, 127),
    tick=st.integers(0, 2**32 - 1),
    pairs=st.lists(st.tuples(st.integers(0, 65535), st.integers(0, 255)), min_size=36, max_size=36),
)
def test_a_result_line_is_read_back(firmware, number, celsius, tick, pairs):
    line = parse(firmware.result_line(number, tick, celsius, pairs))
    assert isinstance(line, ObjLine)
    assert (line.address, line.number, line.temperature_c, line.tick) == (65, number, celsius, tick)
    assert list(zip(line.distance_mm.tolist(), line.confidence.tolist(), strict=True)) == pairs


def test_five_degrees_below_zero_are_printed_as_251(firmware):
    text = firmware.result_line(0, celsius=-5)
    assert text.split(b",")[3] == b"251"
    assert parse(text).temperature_c == -5


def test_a_partial_histogram_says_how_many_bins_it_left_out():
    line = parse(b"#Prt,65,3,126,7,9")
    assert (line.kind, line.skipped, line.values.sum()) == ("Prt", 126, 16)
    assert line.values[126:].tolist() == [7, 9]


def test_a_bare_result_line():
    assert isinstance(parse(b"#Obj"), BareObj)
    assert isinstance(parse(b"#Obj\r"), BareObj)


GOOD = b"#Raw,65,29," + b",".join([b"12"] * 128)


@pytest.mark.parametrize(
    "line",
    [
        GOOD[:-3],
        GOOD + b",1",
        GOOD + b",",
        GOOD.replace(b"12,12", b"1212", 1),
        GOOD.replace(b"12", b"256", 1),
        GOOD.replace(b"12", b"012", 1),
        GOOD.replace(b"12", b"+12", 1),
        GOOD.replace(b"12", b" 12", 1),
        GOOD.replace(b"12", b"1_2", 1),
        GOOD.replace(b"12", b"", 1),
        GOOD.replace(b"12", b"-1", 1),
        GOOD.replace(b"12", "١٢".encode(), 1),
        GOOD.replace(b",29,", b",30,"),
        GOOD.replace(b"#Raw,65", b"#Raw,128"),
        GOOD.replace(b"#Raw", b"#Rawx"),
        GOOD.replace(b"#Raw", b"#Prt"),
        b"#Raw",
        b"#Prt,65",
        b"#Prt,65,3,128",
        b"#Obj,",
        b"#Obj,65,1,25,0,1",
        b"\x80\x81",
        b"a\x00b",
    ],
)
def test_what_is_no_line_is_damaged(line):
    assert isinstance(parse(line), Damaged)


@pytest.mark.parametrize(
    "tick", [b"2147483648", b"-2147483649", b"--1", b"-", b"", b"-0", b"01", b"1e3", b"99999999999"]
)
def test_a_tick_that_is_no_signed_number_of_32_bits_is_damaged(firmware, tick):
    fields = firmware.result_line(1).split(b",")
    fields[5] = tick
    assert isinstance(parse(b",".join(fields)), Damaged)


@pytest.mark.parametrize("text", ["TMF882x state=measure", " DWNL", "#Err,fact calib", "#Conf,Period=16ms", "", "h\te"])
def test_other_text_is_text(text):
    assert parse(text.encode()) == TextLine(text.replace("\t", " "))


@given(line=st.binary(max_size=60), head=st.sampled_from([b"", b"#Raw,", b"#Obj,65,", b"#Prt,65,3,120,"]))
def test_any_bytes_say_something(line, head):
    assert parse(head + line.replace(b"\n", b"")) is not None


@settings(max_examples=50)
@given(at=st.integers(0, len(GOOD) - 1), byte=st.integers(0, 255))
def test_a_byte_that_is_no_digit_never_leaves_a_histogram(at, byte):
    changed = GOOD[:at] + bytes([byte]) + GOOD[at + 1 :]
    line = parse(changed)
    if changed != GOOD and isinstance(line, RawLine):
        assert bytes([byte]).isdigit()
        assert GOOD[at : at + 1].isdigit()

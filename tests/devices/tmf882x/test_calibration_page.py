"""Pages of factory calibration, packed here field by field after the datasheet."""

import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from devices.tmf882x.calibration_page import load_pages, pages_from, save_pages, zone_zero_bins
from recordings.refusal import Refusal

WORDS = arrays(np.uint32, (2, 10))


def packed(positions, crosstalk, kilo=4000, status=0):
    """Header of 4 bytes, then 188: offsets 0x06, 0x10, 0x38, 0x68, 0x90 and 0xB8 hold what a host reads."""
    page = bytearray(192)
    struct.pack_into("<BBBB", page, 0, 0x19, 7, 0xBC, 0)
    struct.pack_into("<H", page, 4 + 0x06, kilo)
    for burst, (position, amplitude) in enumerate([(0x10, 0x38), (0x68, 0x90)]):
        struct.pack_into("<10I", page, 4 + position, *positions[burst].tolist())
        struct.pack_into("<10I", page, 4 + amplitude, *crosstalk[burst].tolist())
    page[4 + 0xB8] = status
    return bytes(page)


def printed(page, name="tmf882x_calib_long_0"):
    out = f"const PROGMEM uint8_t {name}[] = {{\n"
    for row in range(24):
        for column in range(8):
            out += " 0x%X," % page[8 * row + column]  # noqa: UP031
        out += "\n"
    return out + "};\n"


@settings(max_examples=30)
@given(WORDS, WORDS, st.integers(0, 65535), st.integers(0, 255))
def test_what_a_page_says(positions, crosstalk, kilo, status):
    content = packed(positions, crosstalk, kilo, status)
    (page,) = pages_from(printed(content).split("\n"), "test")
    assert (page.content, page.kilo_iterations, page.status) == (content, kilo, status)
    np.testing.assert_array_equal(page.zero_bins, positions.astype(float) / 2**15)
    np.testing.assert_array_equal(page.crosstalk, crosstalk)
    assert page.calibrated == (status == 0 and kilo > 0)


def numbered(count, name):
    """Pages whose zero positions are 100 x page + 10 x burst + channel, in bins."""
    for number in range(count):
        bins = 100 * number + 10 * np.arange(2)[:, None] + np.arange(10)
        yield printed(packed((bins * 2**15).astype(np.uint32), np.zeros((2, 10), np.uint32)), f"{name}{number}")


def test_files_are_kept(tmp_path):
    text = "".join(numbered(4, "tmf8828_calib_short_"))
    (tmp_path / "in.c").write_text(f"#include <stdint.h>\n\n{text}")
    pages = load_pages(tmp_path / "in.c")
    assert [(page.mode_8828, page.ranging, page.number) for page in pages] == [(True, "short", n) for n in range(4)]
    save_pages(pages, tmp_path / "out.c")
    assert (tmp_path / "out.c").read_text() == text


def test_zones_are_those_of_the_channels():
    (one,) = pages_from(next(numbered(1, "tmf882x_calib_long_")).split("\n"), "test")
    assert zone_zero_bins([one], "3x3").tolist() == list(range(1, 10))
    assert zone_zero_bins([one], "4x4").tolist() == [*range(1, 9), *range(11, 19)]
    four = pages_from("".join(numbered(4, "tmf8828_calib_long_")).split("\n"), "test")
    zeros = zone_zero_bins(four, "8x8")
    # The makers' table: sub-capture 0 sees zones 56, 60, 40... in its first burst and 57, 61, 41... in its second.
    assert zeros[[56, 60, 40, 57]].tolist() == [1, 2, 3, 11]
    assert zeros[[58, 48, 50]].tolist() == [101, 201, 301]
    assert zone_zero_bins(four[:3], "8x8") is None


def test_a_sensor_that_was_not_calibrated_has_no_zeros():
    zeros = np.zeros((2, 10), np.uint32)
    pages = pages_from(printed(packed(zeros, zeros, status=0x31)).split("\n"), "test")
    assert zone_zero_bins(pages, "3x3") is None


def test_pages_that_are_not_whole(tmp_path):
    lines = printed(packed(np.ones((2, 10), np.uint32), np.ones((2, 10), np.uint32))).split("\n")
    for spoilt in (lines[:20], [*lines[:5], *lines[6:]], [*lines[:3], lines[3].replace("0x", "0y", 1), *lines[4:]]):
        with pytest.raises(Refusal, match="line 1 begins a page of factory calibration, expected 192 bytes"):
            pages_from(spoilt, "test")
    (tmp_path / "page.c").write_text("int x;\n")
    with pytest.raises(Refusal, match="holds no page of factory calibration"):
        load_pages(tmp_path / "page.c")

"""Lines of a TMF882x to whole measurements: how fast on one core, beside the link and beside `int` of every field.

The peer reads what users read by hand: it splits each line and takes the numbers, and checks nothing.
"""

import numpy as np
import pytest

from recordings.importers.tmf882x.assemble import Assembler

FRAMES = 200
# 2,000,000 baud, a byte being ten bits on the line.
LINK_BYTES_S = 200_000
TIMES_THE_LINK = 20


@pytest.fixture(scope="module")
def lines():
    """Measurements of 3x3 zones: about 900 counts of background, a pulse in each channel."""
    rng = np.random.default_rng(0)
    pulse = 2e4 * np.exp(-0.5 * ((np.arange(128) - 40) / 1.2) ** 2)
    written = []
    for number in range(FRAMES):
        counts = rng.poisson(900 + pulse, (10, 128))
        for plane in range(3):
            rows = counts >> 8 * plane & 255
            written += [f"#Raw,65,{10 * plane + c},{','.join(map(str, rows[c]))}".encode() for c in range(10)]
        written.append(f"#Obj,65,{number % 256},25,9,{2 * number + 1}{',800,200' * 36}".encode())
    return written


def assembled(lines):
    assembler = Assembler("3x3", 4000)
    return sum(assembler.push(line, 0.0) is not None for line in lines)


def by_hand(lines):
    return sum(len([int(field) for field in line.split(b",")[1:]]) for line in lines)


def rate(benchmark, lines, function):
    result = benchmark(function, lines)
    bytes_s = sum(len(line) + 1 for line in lines) / benchmark.stats.stats.median
    benchmark.extra_info["MB/s"] = round(bytes_s / 1e6, 1)
    print(f"\n{function.__name__}: {bytes_s / 1e6:.1f} MB/s, {bytes_s / LINK_BYTES_S:.0f} times the link")
    return result, bytes_s


@pytest.mark.benchmark(group="lines of 200 measurements of a TMF882x")
def test_assembled(benchmark, lines):
    frames, bytes_s = rate(benchmark, lines, assembled)
    assert frames == FRAMES
    assert bytes_s > TIMES_THE_LINK * LINK_BYTES_S


@pytest.mark.benchmark(group="lines of 200 measurements of a TMF882x")
def test_by_hand(benchmark, lines):
    numbers, _ = rate(benchmark, lines, by_hand)
    assert numbers == FRAMES * (30 * 130 + 77)

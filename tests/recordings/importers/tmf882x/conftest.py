"""Writes what the firmware prints, after the protocol's text and not after the reader."""

from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
import pytest


def histogram_lines(channels: np.ndarray, kind: str = "Raw", address: int = 65) -> list[bytes]:
    """30 lines of (10, 128) counts: low, middle and high bytes of channels 0 to 9."""
    lines = []
    for plane in range(3):
        for channel in range(10):
            values = [str(int(count) // 256**plane % 256) for count in channels[channel]]
            lines.append(",".join([f"#{kind}", str(address), str(10 * plane + channel), *values]).encode())
    return lines


def result_line(number: int, tick: int = 1, celsius: int = 25, distances=(), address: int = 65) -> bytes:
    """`#Obj` of 36 pairs; the tick as the signed number and the temperature as the unsigned one the firmware prints."""
    pairs = list(distances) + [(0, 0)] * (36 - len(distances))
    tick %= 2**32
    head = [address, number % 256, celsius % 256, sum(d > 0 for d, _ in pairs), tick - 2**32 * (tick >= 2**31)]
    return ("#Obj," + ",".join(str(int(v)) for v in [*head, *np.ravel(pairs)])).encode()


def place(mode: str, sub: int, slot: int, channel: int) -> int:
    """The zone at which a channel looks."""
    if mode == "8x8":
        row = 7 - 2 * ((channel - 1) // 2) - sub // 2
        return 8 * row + 4 * ((channel - 1) % 2) + slot + 2 * (sub % 2)
    return slot * {"3x3": 0, "4x4": 8, "3x6": 9}[mode] + channel - 1


def measurement(mode: str, counts: np.ndarray, reference: np.ndarray, number: int, **said) -> list[bytes]:
    """All lines of a measurement of (P, 128) counts and the reference of each burst."""
    lines, sets = [], 1 if mode == "3x3" else 2
    for sub in range(4 if mode == "8x8" else 1):
        for slot in range(sets):
            channels = np.zeros((10, 128), int)
            channels[0] = reference[sub * sets + slot]
            for channel in range(1, 9 if mode in ("4x4", "8x8") else 10):
                channels[channel] = counts[place(mode, sub, slot, channel)]
            lines += histogram_lines(channels)
        lines.append(result_line(4 * number + sub if mode == "8x8" else number, **said))
    return lines


def scene(rng: np.random.Generator, frames: int, zones: int = 10, bins: int = 128, width: float = 1.5) -> np.ndarray:
    """(frames, zones, bins) photons of two pulses that move, `width` bins wide (full width at half maximum).

    Levels from a few counts to tens of thousands; each cell Poisson.
    """
    at = np.arange(bins) + 0.5
    sigma = width / 2.3548
    shape = (frames, zones, 1)
    mean = 10 ** rng.uniform(-1, 4, shape) * np.ones(bins)
    for _ in range(2):
        centre = rng.uniform(0, bins, shape)
        mean = mean + 10 ** rng.uniform(0, 5, shape) * np.exp(-0.5 * ((at - centre) / sigma) ** 2)
    return rng.poisson(mean)


@pytest.fixture(scope="session")
def firmware() -> SimpleNamespace:
    """`histogram_lines`, `result_line`, `measurement`, `place` and `scene`."""
    makers: list[Callable] = [histogram_lines, result_line, measurement, place, scene]
    return SimpleNamespace(**{maker.__name__: maker for maker in makers})

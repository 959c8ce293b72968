"""The lines that the firmware prints of a measurement, without their line ends."""

import numpy as np

PLANES = 3  # the low, middle and high byte of a count of 24 bits
BINS = 128


def histogram_lines(counts: np.ndarray, address: int, kind: str = "Raw") -> list[str]:
    """30 lines of a set of ten channels: counts (10, 128), below 2^24; line plane * 10 + channel, low bytes first."""
    if counts.shape != (10, BINS) or counts.min() < 0 or counts.max() >= 1 << 24:
        raise ValueError(f"counts have shape {counts.shape} from {counts.min()} to {counts.max()}, expected 24 bits")
    planes = np.asarray(counts, np.uint32) >> (8 * np.arange(PLANES, dtype=np.uint32))[:, None, None] & 255
    rows = planes.reshape(-1, BINS).tolist()
    return [f"#{kind},{address},{index},{','.join(map(str, row))}" for index, row in enumerate(rows)]


def result_line(
    distance_mm: np.ndarray, confidence: np.ndarray, *, address: int, number: int, temperature_c: int, tick: int
) -> str:
    """The line of a result: (36,) distances and confidences, in pairs.

    As the firmware prints them: the temperature as an unsigned byte, so that -5 degrees become 251, and the clock of 32
    bits as a signed number.
    """
    pairs = np.stack([distance_mm, confidence], axis=1).ravel().tolist()
    valid = np.count_nonzero(confidence)
    signed = tick - 2**32 if tick >= 2**31 else tick
    head = f"#Obj,{address},{number % 256},{temperature_c % 256},{valid},{signed}"
    return f"{head},{','.join(map(str, pairs))}"

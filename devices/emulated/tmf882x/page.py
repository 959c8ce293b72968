"""The chip's pages of factory calibration, 192 bytes each, and how the firmware prints them."""

import numpy as np

from devices.emulated.tmf882x.source import REFERENCE_ZERO
from physics.timing import CROSSTALK, ZERO_BINS

PAGE_BYTES = 192
PAGE_ID, PAYLOAD_BYTES = 0x19, 0xBC
KILO_ITERATIONS = 4000
REFERENCE_CROSSTALK = {"long": 577218, "short": 186993}
FIXED_POINT = 32768  # a position of one bin
NOT_CALIBRATED = 0x31
# Offsets in the payload, for the first and second burst; the crosstalk of the channels follows that of the reference.
ITERATIONS_AT, POSITIONS_AT, CROSSTALK_AT, STATUS_AT = 0x06, (0x10, 0x68), (0x38, 0x90), 0xB8


def empty_page() -> bytes:
    """Of a chip that was not calibrated since it was switched on."""
    return _page(bytearray(PAYLOAD_BYTES), NOT_CALIBRATED)


def calibrated_page(ranging: str, shift_bins: np.ndarray | None = None) -> bytes:
    """As one device's published pages of spad map 6, its zero positions moved by (10,) bins, the reference first."""
    payload = bytearray(PAYLOAD_BYTES)
    payload[ITERATIONS_AT : ITERATIONS_AT + 2] = KILO_ITERATIONS.to_bytes(2, "little")
    bins = np.array([REFERENCE_ZERO[ranging], *ZERO_BINS[ranging]]) + (0 if shift_bins is None else shift_bins)
    positions = np.rint(bins * FIXED_POINT).astype("<u4").tobytes()
    crosstalk = np.array([REFERENCE_CROSSTALK[ranging], *CROSSTALK[ranging]], "<u4").tobytes()
    for position, amplitude in zip(POSITIONS_AT, CROSSTALK_AT, strict=True):
        payload[position : position + len(positions)] = positions
        payload[amplitude : amplitude + len(crosstalk)] = crosstalk
    return _page(payload, 0)


def _page(payload: bytearray, status: int) -> bytes:
    payload[STATUS_AT] = status
    return bytes([PAGE_ID, 0, PAYLOAD_BYTES, 0]) + bytes(payload)


def page_lines(page: bytes, name: str) -> list[str]:
    """As an array of C, eight bytes a line, hexadecimal in capitals and not padded."""
    rows = (page[start : start + 8] for start in range(0, PAGE_BYTES, 8))
    body = ["".join(f" 0x{byte:X}," for byte in row) for row in rows]
    return [f"const PROGMEM uint8_t {name}[] = {{", *body, "};"]

"""Factory calibration: pages of 192 bytes, as the firmware prints them, and what they say of each channel."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from recordings.atomic import written_aside
from recordings.importers.tmf882x.layout import LAYOUTS
from recordings.refusal import Refusal
from recordings.untrusted import reading

PAGE_BYTES, HEADER_BYTES = 192, 4
PAGE_ID, PAYLOAD_BYTES = 0x19, 0xBC
CHANNELS = 10
BEGINS = re.compile(r"const PROGMEM uint8_t tmf88(28|2x)_calib_(long|short)_(\d)\[\] = \{")
EIGHT = re.compile(r"(?: 0x[0-9A-F]{1,2},){8}")
BYTE = re.compile(r"0x([0-9A-F]{1,2})")
# Offsets in the payload, little-endian; of the first and of the second burst. Positions are bins in 1/32768.
ITERATIONS_AT, POSITIONS_AT, CROSSTALK_AT, STATUS_AT = 0x06, (0x10, 0x68), (0x38, 0x90), 0xB8
POSITIONS_PER_BIN = 32768


@dataclass(frozen=True, eq=False)
class CalibrationPage:
    """A page of the sensor's mode (whether that of the TMF8828), ranging ("long" or "short") and number.

    kilo_iterations: it was measured with; 0 where the chip was never calibrated. status: 0 is well.
    zero_bins, crosstalk: (2 bursts, 10 channels, the reference first) time zeros in bins, and counts; the second burst
    is used by modes of more than nine zones. After datasheet DS000693 and the makers' drivers; that positions are
    1/32768 bins is inferred.
    """

    mode_8828: bool
    ranging: str
    number: int
    content: bytes
    kilo_iterations: int
    status: int
    zero_bins: np.ndarray
    crosstalk: np.ndarray

    @property
    def calibrated(self) -> bool:
        """Whether it holds a calibration."""
        return self.status == 0 and self.kilo_iterations > 0

    def said(self) -> dict[str, Any]:
        """As plain values."""
        return {
            "number": self.number,
            "ranging": self.ranging,
            "calibrated": self.calibrated,
            "status": self.status,
            "kilo_iterations": self.kilo_iterations,
            "zero_bins": self.zero_bins.tolist(),
            "crosstalk": self.crosstalk.tolist(),
        }


def pages_from(lines: list[str], place: str) -> list[CalibrationPage]:
    """The pages that are printed in lines; others are passed over, and `Refusal` names a page that is not whole."""
    pages = []
    for at, line in enumerate(lines):
        if (begins := BEGINS.fullmatch(line.strip())) is None:
            continue
        rows = [f" {row.strip()}" for row in lines[at + 1 : at + 1 + PAGE_BYTES // 8]]
        whole = len(rows) == PAGE_BYTES // 8 and all(map(EIGHT.fullmatch, rows))
        content = bytes(int(byte, 16) for row in rows for byte in BYTE.findall(row)) if whole else b""
        if content[:1] != bytes([PAGE_ID]) or content[2:3] != bytes([PAYLOAD_BYTES]):
            raise Refusal(
                f"{place}: line {at + 1} begins a page of factory calibration, expected {PAGE_BYTES} bytes of it in "
                f"lines of eight, as 0x{PAGE_ID:X}, any, 0x{PAYLOAD_BYTES:X} and more"
            )
        pages.append(page_from(content, mode_8828=begins[1] == "28", ranging=begins[2], number=int(begins[3])))
    return pages


def page_from(content: bytes, *, mode_8828: bool, ranging: str, number: int) -> CalibrationPage:
    """What the 192 bytes of a page say."""
    payload = content[HEADER_BYTES:]

    def words(starts: tuple[int, int]) -> np.ndarray:
        return np.stack([np.frombuffer(payload, "<u4", CHANNELS, start) for start in starts])

    return CalibrationPage(
        mode_8828=mode_8828,
        ranging=ranging,
        number=number,
        content=content,
        kilo_iterations=int.from_bytes(payload[ITERATIONS_AT : ITERATIONS_AT + 2], "little"),
        status=payload[STATUS_AT],
        zero_bins=words(POSITIONS_AT) / POSITIONS_PER_BIN,
        crosstalk=words(CROSSTALK_AT),
    )


def zone_zero_bins(pages: list[CalibrationPage], mode: str) -> np.ndarray | None:
    """(P,) time zeros in bins of the zones of a mode, row-major; None without a whole calibration."""
    layout = LAYOUTS[mode]
    used = sorted(pages, key=lambda page: page.number)[: layout.captures]
    if len(used) != layout.captures or not all(page.calibrated for page in used):
        return None
    return layout.zones(np.stack([page.zero_bins[: layout.sets, 1:] for page in used]))


def load_pages(path: str | Path) -> list[CalibrationPage]:
    """Pages out of a file in the form that the firmware prints and is compiled with."""
    with reading(path, "page of factory calibration (an array of C)"):
        lines = Path(path).read_text(encoding="ascii").splitlines()
    pages = pages_from(lines, str(path))
    if not pages:
        raise Refusal(
            f"{path}: holds no page of factory calibration, expected a line as 'const PROGMEM uint8_t tmf88...'"
        )
    return pages


def save_pages(pages: list[CalibrationPage], path: str | Path) -> None:
    """Write them to a file that `load_pages` reads and the firmware can be compiled with."""
    with written_aside(path) as aside:
        aside.write_text("".join(map(page_text, pages)), encoding="ascii")


def page_text(page: CalibrationPage) -> str:
    """As the firmware prints it."""
    rows = (page.content[start : start + 8] for start in range(0, PAGE_BYTES, 8))
    body = "".join("".join(f" 0x{byte:X}," for byte in row) + "\n" for row in rows)
    chip = "28" if page.mode_8828 else "2x"
    return f"const PROGMEM uint8_t tmf88{chip}_calib_{page.ranging}_{page.number}[] = {{\n{body}}};\n"

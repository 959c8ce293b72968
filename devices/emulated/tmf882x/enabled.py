"""The settings of the reference firmware, and the commands that change them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from devices.emulated.tmf882x import texts
from devices.emulated.tmf882x.page import calibrated_page, empty_page, page_lines
from devices.emulated.tmf882x.setting import CHIP_DEFAULT, TABLE, Setting

if TYPE_CHECKING:
    from devices.emulated.tmf882x.firmware import Firmware

ONLY_STOPPED = "cftlrz"
PERSISTENCE = (0, 1, 3)
LOG_LEVELS = (0, 1, 2, 4, 8, 128, 255)
ADDRESSES = (0x41, 0x42)
HISTOGRAM_MODES = 4
CALIBRATION_S, TIMEOUT_MS = 1.0, 100
MODE_8828_REGISTER = 8
RANGING = {True: ("long", 0x6F), False: ("short", 0x6E)}
# How much the zero positions of two calibrations differ, bins.
REPEATABILITY_BINS = 0.03


class Enabled:
    """Settings as the firmware's variables hold them; `setting` and `chip_histograms` as the chip does.

    The chip loses its setting when it changes its mode or is reset, until the firmware configures it anew.
    """

    def __init__(self, firmware: Firmware) -> None:
        self._of = firmware
        self._log = 1
        self.reset(image_8828=True)

    def reset(self, *, image_8828: bool) -> None:
        """As the firmware does before it sets up a chip that was just given its image."""
        self._image_8828 = image_8828 and self._of.chip.has_8x8
        self.mode_8828 = True
        self._long = True
        self._config = self._persistence = self._histograms = 0
        self._clock_correction = True
        self._beyond: tuple[int, int, int] | None = None
        self._pages = [empty_page()] * 4
        self._of.measuring.address = ADDRESSES[0]
        self._forget()

    def one(self, command: str) -> None:
        """What one command does before the line of the state is printed; other characters are an error."""
        act = {
            "o": self._toggle_mode,
            "O": self._toggle_ranging,
            "c": self._next_configuration,
            "t": self._next_persistence,
            "z": self._next_histograms,
            "f": self._calibrate,
            "l": self._print_pages,
            "r": self._restore,
            "a": self._print_registers,
            "x": self._toggle_clock_correction,
            "i": self._next_address,
            "+": lambda: self._log_by(1),
            "-": lambda: self._log_by(-1),
            "#": self._reset_chip,
        }.get(command, lambda: self._of.say([f"#Err,Cmd {command}"]))
        if self._of.state == "stopped" or command not in ONLY_STOPPED:
            act()

    def _toggle_mode(self) -> None:
        self.mode_8828 = not self.mode_8828
        self.switch_mode()

    def _toggle_ranging(self) -> None:
        self._long = not self._long
        if self._of.state == "stopped":
            self.configure()

    def _next_configuration(self) -> None:
        self._config = (self._config + 1) % 3  # the table has two: the reference firmware's own mistake
        self.configure()

    def _next_persistence(self) -> None:
        self._persistence = (self._persistence + 1) % len(PERSISTENCE)
        self.configure()

    def _next_histograms(self) -> None:
        self._histograms = (self._histograms + 1) % HISTOGRAM_MODES
        self.configure()
        self._of.say([f"Histogram is {self._histograms}"])

    def _toggle_clock_correction(self) -> None:
        self._clock_correction = not self._clock_correction
        self._of.say([f"Clk corr is {int(self._clock_correction)}"])

    def _next_address(self) -> None:
        measuring = self._of.measuring
        if self._of.state == "stopped":
            measuring.address = sum(ADDRESSES) - measuring.address
        self._of.say([f"I2C Addr={measuring.address}"])

    def _log_by(self, step: int) -> None:
        self._log = min(max(self._log + step, 0), len(LOG_LEVELS) - 1)
        self._of.say([f"Log={LOG_LEVELS[self._log]}"])

    def _reset_chip(self) -> None:
        if self._of.state != "disabled":
            self._of.say(["Reset TMF8828"])
            self._of.state = "stopped"
            self.switch_mode()

    def switch_mode(self) -> None:
        """Give the chip its mode; where it cannot have it, fall back to that of the smaller sensors."""
        if self._of.state == "disabled":
            self._of.say([texts.NO_CHIP.format(waited=TIMEOUT_MS)], TIMEOUT_MS / 1000)
        elif self._image_8828 or not self.mode_8828:
            self._forget()
            return
        self._of.say([f"#Err,mode switch to,{int(self.mode_8828)}"])
        self.mode_8828 = False

    def configure(self) -> None:
        """Give the chip its setting."""
        period, kilo, spad_map = self._row()
        ranging = RANGING[self._long][0]
        self.setting = Setting(self.mode_8828, self._config, period, kilo, spad_map, ranging)
        self.chip_histograms = self._histograms
        persistence = PERSISTENCE[self._persistence]
        self._of.say([f"#Conf,Period={period}ms,KIter={kilo} SPAD={spad_map} Pers={persistence}"])

    def _row(self) -> tuple[int, int, int]:
        """Of the table; after the last row of one comes the first of the next in memory, then what nobody knows."""
        if self._config < len(TABLE[self.mode_8828]):
            return TABLE[self.mode_8828][self._config]
        if not self.mode_8828:
            return TABLE[True][0]
        if self._beyond is None:
            period, kilo = self._of.rng.integers(0, 65536, 2).tolist()
            self._beyond = (period, kilo, int(self._of.rng.integers(0, 256)))
        return self._beyond

    def _forget(self) -> None:
        """The chip's own defaults."""
        period, kilo, spad_map = CHIP_DEFAULT
        self.setting = Setting(self.mode_8828, 0, period, kilo, 15 if self.mode_8828 else spad_map)
        self.chip_histograms = 0

    def _calibrate(self) -> None:
        pages = 4 if self.mode_8828 else 1
        self._of.say(["Fact Cal"])
        for page in range(pages):
            shift = self._of.rng.normal(0, REPEATABILITY_BINS, 10)
            self._pages[page] = calibrated_page(self.setting.ranging, shift)
        self._of.say([], CALIBRATION_S * pages)
        self.configure()

    def _restore(self) -> None:
        """Load the pages that were compiled into the firmware."""
        self._pages = [calibrated_page(RANGING[self._long][0])] * 4
        self._of.say(["Set fact cal"])

    def _print_pages(self) -> None:
        name = f"tmf88{'28' if self.mode_8828 else '2x'}_calib_{RANGING[self._long][0]}_"
        numbered = enumerate(self._pages) if self.mode_8828 else [(self._config, self._pages[0])]
        for number, page in numbered:
            self._of.say(page_lines(page, f"{name}{number}"))

    def _print_registers(self) -> None:
        """256 of them: those that matter hold what they should, the others nothing."""
        if self._of.state == "disabled":
            return
        registers = bytearray(256)
        registers[0x00:0x04] = bytes(self._of.chip.firmware)
        registers[0x08] = 1 if self._of.state == "measure" else 0
        registers[0x10] = MODE_8828_REGISTER if self.setting.mode_8828 else 0
        registers[0x19] = dict(RANGING.values())[self.setting.ranging]
        registers[0x1C:0x20] = self._of.chip.serial.to_bytes(4, "little")
        registers[0xE0] = 0x41
        self._of.say(texts.register_lines(bytes(registers)))

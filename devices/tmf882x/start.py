"""From whatever state to a sensor that is set as asked and stands still; every setting is read back."""

import re
from dataclasses import dataclass, field
from typing import Any

from calibrate.rig import LidarSetup
from devices.captures import DeviceLost
from devices.tmf882x.calibration_page import CalibrationPage, load_pages, pages_from
from devices.tmf882x.dialogue import TRIES, Answer, NoAnswer, ask
from devices.tmf882x.reader import Reader
from devices.tmf882x.settings import CONF, Setting, setting_from
from recordings.refusal import Refusal

DEVICE = re.compile(r"Driver (\d+\.\d+) FW (\d+(?:\.\d+)*)\.? Chip (\d+\.\d+) Serial 0x([0-9A-F]+)")
HISTOGRAMS = re.compile(r"Histogram is (\d)")
RAW = "1"
STARTS = 5
# Registers 0x18 to 0x1F; 0x19 holds the range mode that the chip runs in.
RANGE_REGISTER = re.compile(r"0x18:\s+0x[0-9A-F]+\s+0x([0-9A-F]+)\s.*")
RANGINGS = {"6E": "short", "6F": "long"}


@dataclass(frozen=True)
class Started:
    """A sensor that was set up. device: driver, firmware, chip, serial.

    ranging: as the chip's register says; None where it does not. pages: of the factory calibration, those of the file
    if one was asked for. given: whether the sensor has the same; None if no file was asked for.
    """

    setting: Setting
    ranging: str | None
    device: dict[str, str]
    pages: list[CalibrationPage] = field(default_factory=list)
    given: bool | None = None

    def same(self) -> dict[str, Any]:
        """What must be as before where a sensor comes back."""
        return {**self.device, "setting": str(self.setting), "ranging": self.ranging}


def start(reader: Reader, setup: LidarSetup) -> Started:
    """Reset the sensor and set it up; begun again where an answer got lost.

    `Refusal` says what this sensor and firmware can be set to, where it is not what was asked for.
    """
    wanted = _wanted(setup)
    for _ in range(STARTS - 1):
        try:
            return _start(reader, setup, wanted)
        except NoAnswer:
            continue
    return _start(reader, setup, wanted)


def _start(reader: Reader, setup: LidarSetup, wanted: list[CalibrationPage]) -> Started:
    ask(reader, "d", state="disabled")
    # The image of the larger sensor is the one that has 8 x 8 zones. Both reset all settings of the firmware.
    enabled = ask(reader, "e" if setup.mode == "8x8" else "E")
    if enabled.state != "stopped":
        raise Refusal(
            f"the LiDAR does not start ({'; '.join(enabled.errors) or f'state={enabled.state}'}): see that the sensor "
            "is wired to its microcontroller and has power"
        )
    device = _expect(enabled, DEVICE)
    setting = _choose(reader, setup, _setting(enabled))
    if setup.ranging == "short":
        ask(reader, "O")
    if wanted:
        ask(reader, "r")  # What the firmware was compiled with: a page cannot be sent.
    pages = _pages(reader)
    given = [page.content for page in pages] == [page.content for page in wanted] if wanted else None
    histograms = ask(reader, "z")
    if _expect(histograms, HISTOGRAMS)[1] != RAW or _setting(histograms) != setting:
        raise NoAnswer("the LiDAR did not keep its setting")
    ranging = RANGINGS.get(_expect(ask(reader, "a"), RANGE_REGISTER)[1])
    if ranging not in (None, setup.ranging):
        raise Refusal(
            f"lidar.ranging is {setup.ranging!r}, but this sensor stays in {ranging} range; set it to {ranging!r}"
        )
    names = dict(zip(("driver", "firmware", "chip", "serial"), device.groups(), strict=True))
    return Started(setting, ranging, names | {"serial": f"0x{device[4]}"}, wanted or pages, given)


def _choose(reader: Reader, setup: LidarSetup, first: Setting) -> Setting:
    """The firmware's first setting, or its second.

    There is no third: the reference firmware reads past the end of its table there, and sets the sensor to whatever it
    finds. So the command for the next one is given once after a reset, and never again.
    """
    if first.serves(setup):
        return first
    answer = ask(reader, "c")
    second = _setting(answer)
    if second.serves(setup):
        return second
    asked = f"{setup.mode} of {setup.kilo_iterations or 'any'} kilo-iterations"
    other = "3x3 and 4x4 are set with another image" if setup.mode == "8x8" and first.mode_8828 else ""
    lacks = "this sensor has no 8 x 8 zones" if setup.mode == "8x8" and not first.mode_8828 else other
    raise Refusal(
        f"lidar.mode and lidar.kilo_iterations ask for {asked}, but this firmware offers {first} and {second}"
        f"{f' ({lacks})' if lacks else ''}; set lidar.mode and lidar.kilo_iterations to one of these"
    )


def _wanted(setup: LidarSetup) -> list[CalibrationPage]:
    """The pages of the file, none without one; `Refusal` where they are of another setting."""
    if not setup.factory_calibration:
        return []
    pages = load_pages(setup.factory_calibration)
    for page in pages:
        if page.ranging != setup.ranging or page.mode_8828 != (setup.mode == "8x8"):
            raise Refusal(
                f"{setup.factory_calibration}: page {page.number} is of {page.ranging} range and "
                f"{'8x8' if page.mode_8828 else '3x3 or 4x4'} zones, but the LiDAR is set to {setup.ranging} range and "
                f"{setup.mode}; name a page of that setting"
            )
    return pages


def _pages(reader: Reader) -> list[CalibrationPage]:
    """The sensor's pages; none where it gives none, for histograms are the same without."""
    try:
        return read_pages(reader)
    except NoAnswer:
        return []


def read_pages(reader: Reader) -> list[CalibrationPage]:
    """The pages of factory calibration that the sensor has now; `NoAnswer` where none arrives whole."""
    for _ in range(TRIES):
        answer = ask(reader, "l", state="stopped")
        try:
            pages = pages_from(list(answer.lines), "LiDAR")
        except Refusal:  # A line got lost.
            continue
        if len(pages) == (4 if answer.mode_8828 else 1):
            return pages
    raise NoAnswer("the LiDAR gives no whole page of factory calibration")


def _setting(answer: Answer) -> Setting:
    return setting_from(_expect(answer, CONF), mode_8828=answer.mode_8828)


def _expect(answer: Answer, pattern: re.Pattern[str]) -> re.Match[str]:
    """The line of an answer; `NoAnswer` if it got lost, `DeviceLost` with the sensor's own words if it has none."""
    if (match := answer.matching(pattern)) is None:
        if answer.errors:
            raise DeviceLost(f"the LiDAR reports {answer.errors[-1]}")
        raise NoAnswer(f"the LiDAR's answer has no line as {pattern.pattern}")
    return match

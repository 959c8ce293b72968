"""A log gone through once for what it says of the sensor's setting; the lines themselves say little of it."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

from recordings.importers.tmf882x.lines import BareObj, ObjLine, RawLine, TextLine, parse
from recordings.refusal import Refusal

# No line of the firmware is as long; a file without line ends is read in pieces of this.
LONGEST_LINE = 1 << 14
# Datasheet DS000693: zones of each SPAD map. The maps that users make, 14 and 15, say nothing.
MODE_OF_MAP = {1: "3x3", 2: "3x3", 3: "3x3", 6: "3x3", 11: "3x3", 12: "3x3", 4: "4x4", 5: "4x4", 7: "4x4", 13: "4x4"}
MODE_OF_MAP[10] = "3x6"
CONF = re.compile(r"#Conf,Period=(\d{1,5})ms,KIter=(\d{1,5}) SPAD=(\d{1,2}) Pers=\d+")
RANGE = re.compile(r"Active range: 6([EF])")
SENSOR = re.compile(r"(TMF8828|TMF882x) state=")
DEVICE = re.compile(r"Driver .* FW .* Chip .* Serial .*")


@dataclass(frozen=True)
class Setting:
    """What the log says; None where it does not. spad_map: as the datasheet numbers them."""

    kilo_iterations: int | None = None
    spad_map: int | None = None
    period_ms: int | None = None
    ranging: str | None = None
    sensor: str | None = None


@dataclass
class Survey:
    """The setting of the measurements, in which mode the lines fit together, and why.

    device: the firmware's own words. sets: how often so many sets of histograms stood before a result line.
    last_channel: whether channel 9 counted anything.
    """

    setting: Setting = Setting()
    device: str | None = None
    sets: dict[int, int] = field(default_factory=dict)
    last_channel: bool = False

    @property
    def mode(self) -> tuple[str, str]:
        """Mode, and what it was taken from."""
        if self.setting.spad_map in MODE_OF_MAP:
            return MODE_OF_MAP[self.setting.spad_map], f"SPAD map {self.setting.spad_map}"
        if max(self.sets, key=self.sets.get, default=1) < 2:
            return "3x3", "one set of histograms before each result"
        if self.setting.sensor == "TMF8828":
            return "8x8", "two sets of histograms before each result of a TMF8828"
        if self.last_channel:
            return "3x6", "two sets of histograms before each result, of nine channels"
        return "4x4", "two sets of histograms before each result, channel 9 empty"


def numbered_lines(path: Path) -> Iterator[tuple[int, bytes]]:
    """Number and text, without its end, of each line."""
    with path.open("rb") as file:
        number = 0
        while line := file.readline(LONGEST_LINE):
            number += 1
            yield number, line.rstrip(b"\n")


def surveyed(path: Path) -> Survey:
    """Go through the file once; `Refusal` names the line where the setting changes amid measurements."""
    found, setting, sets, changed = Survey(), Setting(), 0, 0
    measured = False
    for number, text in numbered_lines(path):
        said = parse(text)
        if isinstance(said, TextLine):
            known = setting
            setting = read_setting(said.text, setting)
            changed = changed if known == setting else number
            found.device = said.text if DEVICE.fullmatch(said.text) else found.device
        elif isinstance(said, RawLine) and said.kind == "Raw":
            if measured and setting != found.setting:
                raise Refusal(
                    f"{path}: line {changed}: the setting changes to {shown(setting)} after measurements with "
                    f"{shown(found.setting)}, expected one setting; split the log there"
                )
            found.setting, measured = setting, True
            sets += said.index == 0
            found.last_channel |= said.index % 10 == 9 and bool(said.values.any())
        elif isinstance(said, ObjLine | BareObj):
            found.sets[sets] = found.sets.get(sets, 0) + (sets > 0)
            sets = 0
    found.setting = found.setting if measured else setting
    return found


def read_setting(text: str, setting: Setting) -> Setting:
    """The setting after a line of text."""
    if match := CONF.fullmatch(text):
        period, iterations, spad_map = map(int, match.groups())
        return replace(setting, period_ms=period, kilo_iterations=iterations or None, spad_map=spad_map)
    if match := RANGE.search(text):
        return replace(setting, ranging="short" if match[1] == "E" else "long")
    if match := SENSOR.match(text):
        return replace(setting, sensor=match[1])
    return setting


def shown(setting: Setting) -> str:
    """A setting in a sentence."""
    said = {name.replace("_", " "): value for name, value in vars(setting).items() if value is not None}
    return ", ".join(f"{name} {value}" for name, value in said.items()) or "none"

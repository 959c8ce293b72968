"""A sensor that measures again and again, and prints each measurement line by line."""

from collections.abc import Iterator

import numpy as np

from devices.emulated.tmf882x.chip import Chip
from devices.emulated.tmf882x.encode import histogram_lines, result_line
from devices.emulated.tmf882x.objects import find_objects
from devices.emulated.tmf882x.outbox import Outbox
from devices.emulated.tmf882x.setting import Setting
from devices.emulated.tmf882x.source import Source

RAW, ELECTRICAL = 1, 2  # bits of the histogram mode
# Reading 135 bytes of nine bits over I2C at 400 kHz, before a line can be printed.
LINE_READ_S = 135 * 9 / 400e3
# Where the two peaks of the electrical calibration stand is published nowhere; these are as good as any.
ELECTRICAL_BINS, ELECTRICAL_COUNT = (20, 90), 4000


class Measuring:
    """Measurements of one source, printed to `out`; results are numbered from 0 at each start.

    All bursts are fired before any line is printed, and the next measurement begins when the last line is out.
    `address`: of the chip on its bus.
    """

    def __init__(self, source: Source, chip: Chip, out: Outbox) -> None:
        self._source, self._chip, self._out = source, chip, out
        self._setting: Setting | None = None
        self._histograms = 0
        self._begun = 0.0
        self._number = 0
        self._printing = False
        self.address = 0x41

    @property
    def running(self) -> bool:
        """Whether it measures."""
        return self._setting is not None

    def start(self, setting: Setting, histograms: int, now: float) -> None:
        """Begin to measure."""
        self._setting, self._histograms, self._begun, self._printing = setting, histograms, now, False
        self._number = 0

    def stop(self) -> None:
        """Stop; what was begun is lost."""
        self._setting = None

    @property
    def next_due(self) -> float | None:
        """When the measurement that runs is over; None while lines are printed, or nothing is measured."""
        return None if self._setting is None or self._printing else self._ends

    @property
    def _ends(self) -> float:
        return self._begun + self._setting.burst_s * self._setting.sets

    def advance(self, now: float) -> bool:
        """Print the measurement that is over by `now`; the next one begins once its lines are out."""
        if self._setting is None:
            return False
        if self._printing and self._out.next_due is None:
            self._printing = False
            self._begun = max(now, self._begun + self._setting.period_ms / 1000)
        if self._printing or now < self._ends:
            return False
        at = self._ends
        for line in self._lines(self._setting, self._source(self._setting)):
            at += LINE_READ_S
            self._out.put(line.encode("ascii") + b"\n", at)
        self._printing = True
        return True

    def _lines(self, setting: Setting, counts: np.ndarray) -> Iterator[str]:
        """Of a whole measurement: each capture its sets of histograms, then its result."""
        by_capture = np.asarray(counts).reshape(setting.captures, setting.bursts, *np.shape(counts)[1:])
        for sets in by_capture:
            for one in sets:
                if self._histograms & ELECTRICAL:
                    yield from histogram_lines(_electrical(one.shape), self.address, "Cal")
                if self._histograms & RAW:
                    yield from histogram_lines(one, self.address)
            distance, confidence = find_objects(sets, setting.ranging)
            yield result_line(
                distance,
                confidence,
                address=self.address,
                number=self._number,
                temperature_c=self._chip.temperature_c,
                tick=self._chip.tick(self._ends),
            )
            self._number += 1


def _electrical(shape: tuple[int, ...]) -> np.ndarray:
    """Histograms of the electrical calibration: two peaks."""
    counts = np.zeros(shape, np.uint32)
    counts[:, ELECTRICAL_BINS] = ELECTRICAL_COUNT
    return counts

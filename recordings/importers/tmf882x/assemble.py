"""Lines of a TMF882x put together to whole measurements, and nothing but whole ones.

The format has no checksum. What it does have is used: between two result lines there must be every line of the
measurement, once, in order, and the result's number must follow the one before, so whatever was lost, doubled,
exchanged or cut is known by what is missing. A number does not follow when a result line was lost, too: the histograms
may then be those of another measurement, so that one is dropped as well. After `begin` there is no number before; the
first measurement is taken on its lines alone.

What it cannot tell: a digit that became another digit, or that was lost inside a field, leaves a well-formed line. Of
these `plausible` finds those that are impossible, or stand alone far beyond photon noise; a change within that
remains. Lines of the same index exchanged between two measurements, which a serial line does not do, and a loss of a
multiple of 256 measurements in one piece (64 in 8x8) cannot be told either; nor, with firmware whose result lines say
nothing, any loss that ends where it began in a later measurement.
"""

import math
from dataclasses import dataclass

import numpy as np

from recordings.importers.tmf882x.clock import Clock, Count
from recordings.importers.tmf882x.gather import Gatherer
from recordings.importers.tmf882x.layout import LAYOUTS
from recordings.importers.tmf882x.lines import BareObj, Damaged, ObjLine, RawLine, TextLine, parse
from recordings.importers.tmf882x.plausible import implausible
from recordings.importers.tmf882x.tally import Tally
from recordings.refusal import Refusal

NUMBERS = 256


@dataclass(frozen=True, eq=False)
class Assembled:
    """A whole measurement of P zones.

    counts: (P, 128) uint32, zones row-major. reference: (bursts, 128) uint32. distance_mm: (P, 2) uint16, confidence:
    (P, 2) uint8, what the chip found, nearest first; None where the firmware says nothing. temperature_c: NaN likewise.
    number: counts on past what the firmware prints. tick_s: the chip's clock, NaN where not valid. host_s: when the
    first line came. missed: measurements since the one before that the sensor counted and that were not handed on.
    """

    counts: np.ndarray
    reference: np.ndarray
    distance_mm: np.ndarray | None
    confidence: np.ndarray | None
    temperature_c: float
    number: int
    tick_s: float
    host_s: float
    missed: int


class Assembler:
    """Takes one line after another, gives a measurement at its last line.

    mode: 3x3, 4x4, 3x6 or 8x8. kilo_iterations: of 1024 laser shots; without it, or 0, a count is bounded by its
    24 bits alone. tally: what came and what was lost.
    """

    def __init__(self, mode: str = "3x3", kilo_iterations: int | None = None) -> None:
        if mode not in LAYOUTS:
            raise Refusal(f"mode {mode!r} is none of the sensor's, expected one of {', '.join(LAYOUTS)}")
        self._layout = LAYOUTS[mode]
        self._shots = 1024 * kilo_iterations if kilo_iterations else None
        self._gatherer = Gatherer(self._layout.sets)
        self._count = Count(NUMBERS // self._layout.captures)
        self.tally = Tally()
        self.reset()

    def reset(self) -> None:
        """After the sensor was gone: its clock begins anew, and so does everything but the count of measurements."""
        self._clock = Clock()
        self._before: np.ndarray | None = None
        self._bare = True
        self.begin()

    def begin(self) -> None:
        """After measuring was started anew: the next line is the first of a measurement, with any number."""
        self._gatherer.start()
        self._captures: list[tuple[np.ndarray, ObjLine | None]] = []
        self._expected: int | None = None
        self._failed: int | None = None
        self._fresh = True
        self._first_s = math.nan

    def push(self, line: bytes, host_s: float) -> Assembled | None:
        """One line without its newline that came at `host_s`; a measurement if it was the last of one."""
        said = parse(line)
        self.tally.lines += 1
        if isinstance(said, RawLine):
            self._histogram(said, host_s)
        elif isinstance(said, ObjLine):
            self._bare = False
            return self._result(said, said.number)
        elif isinstance(said, BareObj):
            # Where other results say more, this one was cut.
            return self._result(None, self._follows()) if self._bare else self._damaged(b"#Obj", "a result cut short")
        elif isinstance(said, Damaged):
            return self._damaged(line, said.why)
        else:
            self._foreign(said)
        return None

    def _histogram(self, line: RawLine, host_s: float) -> None:
        if line.kind == "Cal":
            self.tally.calibration += line.index == 0
            return
        if not (self._gatherer.any or self._captures):
            self._first_s = host_s
        self._gatherer.add(line)

    def _foreign(self, line: TextLine) -> None:
        self.tally.foreign += 1
        # The firmware says its state when it was started or stopped, maybe in the middle of a measurement.
        if " state=" in line.text:
            self.begin()

    def _damaged(self, line: bytes, why: str) -> None:
        self.tally.damaged += 1
        self.tally.reasons[why.partition(",")[0]] += 1
        if line.startswith(b"#Obj"):
            self._drop("a damaged result line", self._follows())
            self._captures = []
            self._gatherer.start()
            self._expected = None if self._expected is None else (self._expected + 1) % NUMBERS

    def _follows(self) -> int:
        """The number that the next result has, if none is lost."""
        return 0 if self._expected is None else self._expected

    def _result(self, line: ObjLine | None, number: int) -> Assembled | None:
        """The end of a capture: its histograms, if they are whole and their number follows."""
        if not self._gatherer.any and self._expected == (number + 1) % NUMBERS and line is not None:
            return None  # the same result line once more
        sets = self._gatherer.finish(None if line is None else line.address)
        fault = self._gatherer.fault
        if fault is None and self._expected not in (None, number):
            fault = "its number does not follow"
        self._gatherer.start()
        self._expected = (number + 1) % NUMBERS
        part = number % self._layout.captures
        if fault is None and part != len(self._captures):
            fault = "began in the middle"
        if fault is not None:
            self._captures = []
            self._drop(fault, number)
            return None
        self._captures.append((sets, line))
        return self._whole(number // self._layout.captures) if len(self._captures) == self._layout.captures else None

    def _drop(self, fault: str, number: int) -> None:
        """Count a measurement once, however many of its parts are at fault."""
        number //= self._layout.captures
        if number != self._failed:
            self.tally.dropped += 1
            self.tally.reasons[fault] += 1
        self._failed = number

    def _whole(self, number: int) -> Assembled | None:
        """All captures of a measurement are there: what they say, if it can be."""
        sets = np.stack([one for one, _ in self._captures])
        lines = [line for _, line in self._captures]
        self._captures = []
        before, self._before = self._before, sets
        fault = implausible(sets, before, self._shots)
        if fault is not None:
            self._drop(fault, number * self._layout.captures)
            return None
        # One that says nothing, among others, was cut: what the rest say is not of all zones.
        last = None if None in lines else lines[-1]
        fresh, earlier = self._fresh, self._count.last
        counted = self._count.next(number)
        missed = 0 if fresh or earlier is None else counted - earlier - 1
        self._fresh = False
        self.tally.frames += 1
        self.tally.missed += missed
        return Assembled(
            counts=self._layout.zones(sets[:, :, 1:]),
            reference=sets[:, :, 0].reshape(-1, sets.shape[-1]),
            distance_mm=None if last is None else self._records([line.distance_mm for line in lines]),
            confidence=None if last is None else self._records([line.confidence for line in lines]),
            temperature_c=math.nan if last is None else float(last.temperature_c),
            number=counted,
            tick_s=math.nan if last is None else self._clock.seconds(last.tick, self._first_s),
            host_s=self._first_s,
            missed=missed,
        )

    def _records(self, values: list[np.ndarray]) -> np.ndarray:
        """(P, 2) of the zones from (36,) of each capture, which are (object, set, channel)."""
        records = np.stack(values).reshape(len(values), 2, 2, 9)
        return self._layout.zones(records.transpose(0, 2, 3, 1)[:, : self._layout.sets])

"""Reads the port in a thread: no line is lost while nobody asks, and of whole measurements only so many wait."""

import threading
import time
from collections import deque
from collections.abc import Callable

import serial

from devices.captures import DeviceLost
from recordings.importers.tmf882x.assemble import Assembled, Assembler
from recordings.importers.tmf882x.lines import PREFIXES

# Longer than any line: a result of 78 fields has 500 characters at most, a histogram 530.
LONGEST_LINE = 4096
MOST_FRAMES = 64
# How a port goes away: pyserial's own errors are OSError, but for a port just closed. All else is a mistake of ours.
GONE = (OSError, EOFError, TypeError)
MOST_TEXTS = 1024
# What text and data are made of.
READABLE = bytes([9, 10, 13, *range(32, 127)])


class Reader:
    """Lines of text and whole measurements as they arrive.

    `data_lines`, `text_lines`, `noise_bytes`: lines that came that begin as data, or are other text; bytes of no text.
    `overrun`: measurements that were pushed out because nobody took them. `host`: the clock of arrivals, seconds since
    the epoch.
    """

    def __init__(self, port: serial.Serial, host: Callable[[], float] = time.time) -> None:
        self._port, self._host = port, host
        self._news = threading.Condition()
        self._assembler: Assembler | None = None
        self._texts: deque[str] = deque(maxlen=MOST_TEXTS)
        self._frames: deque[Assembled] = deque()
        self._closing = False
        self._failure: Exception | None = None
        self._heard = time.monotonic()
        self._begun = 0, 0  # Lines of data and losses, when measuring last began.
        self.data_lines = self.text_lines = self.noise_bytes = self.overrun = 0
        self._thread = threading.Thread(target=self._read, name=f"reads {port.name}", daemon=True)
        self._thread.start()

    def assemble(self, assembler: Assembler) -> None:
        """Put measurements together by this from now on."""
        with self._news:
            self._assembler = assembler
            self._frames.clear()

    def begin(self) -> int:
        """Forget measurements, how many is returned, and text; the next line is the first of a measurement."""
        with self._news:
            forgotten = len(self._frames)
            self._frames.clear()
            self._texts.clear()
            if self._assembler is not None:
                self._assembler.begin()
            self._begun = self.data_lines, self._dropped()
            return forgotten

    def write(self, data: bytes) -> None:
        """Send; raises `DeviceLost`."""
        try:
            self._port.write(data)
        except GONE as failure:
            raise DeviceLost(f"{self._port.name} went away: {failure}") from failure

    def forget_texts(self) -> None:
        """Forget what was said before."""
        with self._news:
            self._texts.clear()

    def next_text(self, until: float) -> str | None:
        """The next line of text, None if none came by `until` of the monotonic clock; raises `DeviceLost`."""
        with self._news:
            self._wait(lambda: self._texts, until)
            return self._texts.popleft() if self._texts else None

    def next_frame(self, until: float) -> Assembled | str | None:
        """The next measurement, or an error that the firmware reports; None if neither came; raises `DeviceLost`."""
        with self._news:
            self._wait(lambda: self._frames or self._error(), until)
            return self._frames.popleft() if self._frames else self._error()

    def next_data(self, until: float) -> bool:
        """Whether a line of data came since `begin`, or comes by `until`; raises `DeviceLost`."""
        with self._news:
            self._wait(lambda: self.data_lines > self._begun[0] or self._error(), until)
            return self.data_lines > self._begun[0]

    def first_frame(self, silence_s: float) -> Assembled | None:
        """The first measurement since `begin`, None once it is known to be lost; raises `DeviceLost`."""
        with self._news:
            while not self._frames and self._dropped() == self._begun[1]:
                if self._error() or time.monotonic() > self._heard + silence_s:
                    return None
                self._wait(
                    lambda: self._frames or self._error() or self._dropped() > self._begun[1], self._heard + silence_s
                )
            whole = self._frames and self._dropped() == self._begun[1]
            return self._frames.popleft() if whole else None

    @property
    def heard(self) -> float:
        """When the last line came, on the monotonic clock."""
        return self._heard

    def close(self) -> None:
        """Stop reading, close the port."""
        self._closing = True
        self._port.cancel_read()
        self._thread.join()
        self._port.close()

    def _dropped(self) -> int:
        """Measurements that were lost so far, and lines."""
        tally = None if self._assembler is None else self._assembler.tally
        return 0 if tally is None else tally.dropped + tally.damaged

    def _error(self) -> str | None:
        """What the firmware said is wrong, the last of it."""
        return next((text for text in reversed(self._texts) if text.startswith("#Err")), None)

    def _wait(self, ready: Callable[[], object], until: float) -> None:
        """Until it is ready, or the time has come; the lock is held."""
        while not ready() and (left := until - time.monotonic()) > 0:
            if isinstance(self._failure, GONE):
                raise DeviceLost(f"{self._port.name} went away: {self._failure}")
            if self._failure is not None:
                raise self._failure
            self._news.wait(left)

    def _read(self) -> None:
        rest, rest_s = b"", 0.0
        try:
            while not self._closing:
                data = self._port.read(max(1, self._port.in_waiting))
                now = self._host()
                self.noise_bytes += len(data.translate(None, READABLE))
                if not rest:
                    rest_s = now
                *lines, rest = (rest + data).split(b"\n")
                if len(rest) > LONGEST_LINE:
                    lines, rest = [*lines, rest], b""
                if lines:
                    self._take(lines, rest_s, now)
                    rest_s = now
        except Exception as failure:  # whoever waits for lines must hear of it; this thread has nobody to tell
            self._failure = failure
        with self._news:
            self._failure = self._failure or EOFError("it was closed")
            self._news.notify_all()

    def _take(self, lines: list[bytes], first_s: float, now: float) -> None:
        """Lines that arrived; the first may have begun earlier."""
        with self._news:
            self._heard = time.monotonic()
            for number, line in enumerate(lines):
                self._one(line, first_s if number == 0 else now)
            self._news.notify_all()

    def _one(self, line: bytes, host_s: float) -> None:
        if line.startswith(PREFIXES):
            self.data_lines += 1
        elif not line.translate(None, READABLE) and (text := line.decode("ascii").rstrip("\r")).isprintable():
            self.text_lines += 1
            self._texts.append(text)
        if self._assembler is not None and (frame := self._assembler.push(line, host_s)) is not None:
            if len(self._frames) == MOST_FRAMES:
                self._frames.popleft()
                self.overrun += 1
            self._frames.append(frame)

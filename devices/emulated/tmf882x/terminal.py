"""Serves an emulated sensor at a serial port like any other, in a thread of its own."""

import os
import select
import threading
import time
from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import Protocol

import numpy as np

from devices.emulated.tmf882x.faults import NO_FAULTS, Faults, damaged
from devices.emulated.tmf882x.pseudo_terminal import PseudoTerminal

NEVER = float("inf")
MIDST = 15  # of the 30 lines of a measurement


class Emulated(Protocol):
    """A firmware; its clock is the `now` it is given, seconds."""

    baud: int

    @property
    def next_due(self) -> float | None:
        """When there will be something to take; None if nothing happens by itself."""

    def boot(self, now: float) -> None:
        """As after power came."""

    def write(self, data: bytes, now: float) -> None:
        """Characters that arrive."""

    def take(self, now: float) -> list[bytes]:
        """What was sent by `now`, a line each."""


class Terminal:
    """A firmware at the port `link`, a symbolic link, until closed; also a context manager.

    speed: how many times faster than real time its clock runs. `clock`: the real one, seconds. `failure` is what ended
    the service, if something did: the port goes away then.
    """

    def __init__(
        self,
        firmware: Emulated,
        link: str | Path,
        *,
        speed: float = 1.0,
        faults: Faults = NO_FAULTS,
        rng: np.random.Generator | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.link = Path(link)
        self.failure: Exception | None = None
        self._firmware, self._speed, self._faults, self._clock = firmware, speed, faults, clock
        self._rng = np.random.default_rng(0) if rng is None else rng
        self._began = clock()
        self._unplug_at, self._stall_at = set(faults.unplug_at), set(faults.stall_at)
        self._back_at = self._still_until = -NEVER
        self._results = self._lines_of_result = 0
        self._lines: deque[bytes] = deque()
        self._unsent = b""
        self._orders: deque[Callable[[], None]] = deque()
        self._wakes, self._wake = os.pipe()
        self._closing = False
        self._port: PseudoTerminal | None = PseudoTerminal(self.link, firmware.baud, self._rng)
        self._thread = threading.Thread(target=self._serve, name=f"emulated TMF882x at {link}", daemon=True)
        self._thread.start()

    def __enter__(self) -> "Terminal":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def unplug(self, back_after_s: float = NEVER) -> None:
        """Pull the cable; it comes back after so many seconds of the sensor's clock, freshly booted."""
        self._order(lambda: self._pull(back_after_s))

    def plug_in(self) -> None:
        """Put the cable back, if it is pulled."""
        self._order(lambda: setattr(self, "_back_at", -NEVER))

    def close(self) -> None:
        """Stop serving; the port goes away."""
        if not self._closing:
            self._closing = True
            self._order(lambda: None)
            self._thread.join()
            os.close(self._wakes)
            os.close(self._wake)

    def _order(self, what: Callable[[], None]) -> None:
        """Have the thread that serves do something."""
        self._orders.append(what)
        os.write(self._wake, b".")

    def _now(self) -> float:
        return (self._clock() - self._began) * self._speed

    def _serve(self) -> None:
        try:
            while not self._closing:
                self._once()
        except Exception as failure:  # of the firmware or its source: kept for whoever made it, the port goes away
            self.failure = failure
        finally:
            self._pull(NEVER)

    def _once(self) -> None:
        """Wait until something can be done, and do it."""
        if self._port is None and self._now() >= self._back_at:
            self._firmware.boot(self._now())
            self._port = PseudoTerminal(self.link, self._firmware.baud, self._rng)
        ports = [] if self._port is None else [self._port]
        readable, _, _ = select.select([self._wakes, *ports], ports if self._unsent else [], [], self._wait_s())
        if self._wakes in readable:
            os.read(self._wakes, 1)
            self._orders.popleft()()
        if self._port in readable:
            self._firmware.write(self._port.read(), self._now())
        # A firmware whose line is full waits, and measures nothing meanwhile.
        if self._port is not None and not self._unsent and self._now() >= self._still_until:
            self._next_lines()
        if self._port is not None and self._unsent:
            self._unsent = self._port.write(self._unsent)

    def _wait_s(self) -> float | None:
        """Real seconds until something happens by itself; None for never."""
        if self._port is None:
            due = self._back_at
        elif self._unsent:
            return None
        else:
            due = self._firmware.next_due
            due = max(NEVER if due is None and not self._lines else due or 0.0, self._still_until)
        return None if due == NEVER else max(0.0, (due - self._now()) / self._speed)

    def _next_lines(self) -> None:
        """Send lines, through what may befall them."""
        if not self._lines:
            self._lines.extend(self._firmware.take(self._now()))
        while self._lines:
            line = self._lines.popleft()
            self._lines_of_result += line.startswith((b"#Raw", b"#Cal"))
            if line.startswith(b"#Obj"):
                self._results, self._lines_of_result = self._results + 1, 0
            if self._lines_of_result == MIDST and self._results in self._unplug_at:
                self._unplug_at.remove(self._results)
                self._pull(self._faults.back_after_s)
                return
            self._unsent += damaged(line, self._faults, self._rng)
            if self._lines_of_result == MIDST and self._results in self._stall_at:
                self._stall_at.remove(self._results)
                self._still_until = self._now() + self._faults.stall_s
                return

    def _pull(self, back_after_s: float) -> None:
        if self._port is not None:
            self._port.close()
        self._port, self._unsent, self._lines_of_result = None, b"", 0
        self._lines.clear()
        self._back_at = self._now() + back_after_s

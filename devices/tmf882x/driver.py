"""The LiDAR: measurements on demand or as a stream, whatever befalls the cable meanwhile."""

import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any

from calibrate.rig import LidarSetup
from devices.captures import DeviceLost, Measurement
from devices.tmf882x.attached import Attached
from devices.tmf882x.connection import Connection
from devices.tmf882x.dialogue import ask
from devices.tmf882x.factory import FactoryCalibration
from devices.tmf882x.one_shot import await_integrated, is_single, read_out
from devices.tmf882x.port import usb_ports
from devices.tmf882x.said import said
from recordings.importers.tmf882x.assemble import Assembled

# For how many times as long as nothing may come, nothing that is whole may.
NOTHING_WHOLE = 10
# The first line of a measurement can be late by the time that reading it from the chip takes, and by the USB's.
LATE_S = 0.05


def _silent(sentence: str) -> None:
    """Nobody listens."""


def open_tmf882x(
    setup: LidarSetup,
    *,
    reconnect_s: float = 0.0,
    progress: Callable[[str], None] = _silent,
    find: Callable[[], list[str]] = usb_ports,
) -> "Tmf882x":
    """The sensor of `setup`, set up and at rest.

    reconnect_s: how long `measure` and `frames` wait for a sensor that went away; 0 leaves that to the caller.
    progress: told what is waited for. find: the ports to try where `setup` names none. `Refusal` says what is wrong
    and what to do about it.
    """
    return Tmf882x(Attached(setup, reconnect_s, progress, find), setup, progress)


class Tmf882x(FactoryCalibration):
    """A `devices.captures.Lidar`; also a context manager, which closes it. Made by `open_tmf882x`."""

    def __init__(self, attached: Attached, setup: LidarSetup, progress: Callable[[str], None]) -> None:
        self._attached, self._setup, self._progress = attached, setup, progress
        self._number = -1
        self._before: int | None = None  # The assembler's number of the measurement before, since the last start.
        self._running: Connection | None = None  # That which was told to measure, and not yet to stop.
        self._dropped = self._errors = 0

    def __enter__(self) -> "Tmf882x":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def said(self) -> dict[str, Any]:
        """Firmware, chip, settings as read back, factory calibration, and what was lost so far."""
        link = self._attached.last
        overrun = link.reader.overrun
        lost = {"reconnects": self._attached.again, "errors": self._errors, "overrun": overrun}
        return said(self._setup, link, lost | link.assembler.tally.said())

    def measure(self) -> Measurement:
        """A measurement all of which was taken after the call; raises `DeviceLost` where the sensor is gone."""
        called_s = time.time()
        return self._attached.patiently(lambda: self._measure(called_s))

    def integrate(self) -> None:
        """Take one measurement; returns as soon as it is taken, for `read` to read; raises `DeviceLost`."""
        called_s = time.time()
        self._taken = self._attached.patiently(lambda: self._integrated(called_s))

    def read(self) -> Measurement | None:
        """The measurement that `integrate` took, None where part of it was lost; raises `DeviceLost`."""
        if self._taken is not None:
            return self._taken
        frame = read_out(self._attached.link)
        self._running = None
        return None if frame is None else self._measurement(frame)

    def frames(self) -> Iterator[Measurement]:
        """Measurements as they come, without end; measuring stops when the iterator is closed."""
        try:
            while True:
                yield self._attached.patiently(self._streamed)
        finally:
            self._stop()

    def reopen(self, timeout_s: float) -> None:
        """Wait for the sensor to come back, set it up as it was; `DeviceLost` if it does not within `timeout_s`.

        `Refusal` where what comes back is another sensor, or cannot be set as it was.
        """
        self._attached.reopen(timeout_s)

    def close(self) -> None:
        """Stop measuring and let go of the device."""
        try:
            self._stop()
        finally:
            self._attached.close()

    def _measure(self, called_s: float) -> Measurement:
        link = self._attached.link
        if link.started is not None:
            # What runs still, in a stream that was not closed or after an error, began before.
            if self._running is link:
                ask(link.reader, "s", state="stopped")
            self._begin()
            one = self._next()
            self._stop()
            return one
        # A measurement whose lines come now was taken before. The next may have begun before, too; the one after that
        # began when it ended.
        while self._next().host_s < called_s + LATE_S:
            pass
        return self._next()

    def _integrated(self, called_s: float) -> Measurement | None:
        """The measurement, where only reading it says that it was taken."""
        link = self._attached.link
        if not is_single(link, self._setup.mode):
            return self._measure(called_s)
        if self._running is link:
            self._stop()
        self._begin()
        await_integrated(link)
        return None

    def _streamed(self) -> Measurement:
        """The next of a stream, which is begun where nothing is measured."""
        if self._running is not self._attached.link:
            self._begin()
        return self._next()

    def _begin(self) -> None:
        self._running = link = self._attached.link
        if link.started is not None:
            self._number += link.reader.begin()
            self._before = None
            ask(link.reader, "m", state="measure")

    def _stop(self) -> None:
        """At rest again, if it is still there."""
        with suppress(DeviceLost):
            link = self._attached.link
            if link.started is not None:
                ask(link.reader, "s", state="stopped")
            self._running = None

    def _next(self) -> Measurement:
        """The next whole measurement; those that were lost or damaged are passed over."""
        link = self._attached.link
        began = asked = time.monotonic()
        while True:
            frame = link.reader.next_frame(max(asked, link.reader.heard) + link.silence_s)
            if isinstance(frame, Assembled):
                return self._measurement(frame)
            if frame is not None:  # The firmware reports an error, after which it measures no more.
                self._errors += 1
                self._progress(f"the LiDAR reports {frame}")
                link.reader.forget_texts()
                self._begin()
                asked = time.monotonic()
            now = time.monotonic()
            if now >= max(asked, link.reader.heard) + link.silence_s:
                raise DeviceLost(f"nothing came from the LiDAR for {link.silence_s:.1f} s")
            if now >= began + NOTHING_WHOLE * link.silence_s:
                raise DeviceLost(f"no whole measurement came from the LiDAR for {now - began:.0f} s")

    def _measurement(self, frame: Assembled) -> Measurement:
        # The sensor's own number begins anew with every start: what was lost since then was seen to be.
        dropped, self._dropped = self._dropped, self._attached.link.assembler.tally.dropped
        self._number += 1 + self._dropped - dropped if self._before is None else frame.number - self._before
        self._before = frame.number
        return Measurement(
            counts=frame.counts,
            reference=frame.reference,
            distance_mm=frame.distance_mm,
            confidence=frame.confidence,
            temperature_c=frame.temperature_c,
            number=self._number,
            device_s=frame.tick_s,
            host_s=frame.host_s,
        )

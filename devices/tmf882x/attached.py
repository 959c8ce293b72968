"""A connection that may be lost and had again: another cable, the same sensor, the same settings."""

import time
from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

from calibrate.rig import LidarSetup
from devices.captures import DeviceLost
from devices.tmf882x.calibration_page import CalibrationPage
from devices.tmf882x.connection import Connection, connect
from recordings.refusal import Refusal

TRY_AGAIN_S = 0.2

Result = TypeVar("Result")


class Attached:
    """Holds the connection to the sensor of `setup`; `again` counts how often it was lost and had again.

    reconnect_s: how long `patiently` waits for a sensor that went away. progress: told what is waited for.
    """

    def __init__(
        self, setup: LidarSetup, reconnect_s: float, progress: Callable[[str], None], find: Callable[[], list[str]]
    ) -> None:
        self._setup, self._progress, self._find = setup, progress, find
        self.reconnect_s = reconnect_s
        self.again = 0
        self._last = self._link = connect(setup, None, find)

    @property
    def last(self) -> Connection:
        """The connection, or the last there was."""
        return self._last

    @property
    def link(self) -> Connection:
        """The connection; raises `DeviceLost` if there is none."""
        if self._link is None:
            raise DeviceLost("the LiDAR is not connected; it may be opened anew")
        return self._link

    def calibrated(self, pages: list[CalibrationPage]) -> list[CalibrationPage]:
        """Note that the sensor has other pages of factory calibration than at its start; returns them."""
        started = self.link.started
        if started is not None:
            self._last = self._link = replace(self.link, started=replace(started, pages=pages, given=None))
        return pages

    def close(self) -> None:
        """Let go of the port."""
        link, self._link = self._link, None
        if link is not None:
            link.reader.close()

    def patiently(self, work: Callable[[], Result]) -> Result:
        """Do it; where the sensor is lost and may come back, wait for it and do it anew."""
        while True:
            try:
                return work()
            except DeviceLost:
                if self.reconnect_s <= 0:
                    raise
            self.reopen(self.reconnect_s)

    def reopen(self, timeout_s: float) -> None:
        """Wait for the sensor to come back, set it up as it was; `DeviceLost` if it does not within `timeout_s`.

        `Refusal` where what comes back is another sensor, or cannot be set as it was.
        """
        self.close()
        before = self._last
        self._progress(f"the LiDAR at {before.port} is gone; waiting for it to come back")
        link = self._connect_by(time.monotonic() + timeout_s, timeout_s)
        was, now = before.same(), link.same()
        changed = [
            f"{name} was {was.get(name)}, is {now.get(name)}" for name in was | now if was.get(name) != now.get(name)
        ]
        if changed:
            link.reader.close()
            raise Refusal(
                f"another LiDAR came back at {link.port} ({'; '.join(changed)}); connect the one that was there"
            )
        self._last = self._link = link
        self.again += 1
        self._progress("the LiDAR is back")

    def _connect_by(self, until: float, timeout_s: float) -> Connection:
        while True:
            try:
                return connect(self._setup, self._last.assembler, self._find)
            except (Refusal, DeviceLost) as no:
                if time.monotonic() >= until:
                    raise DeviceLost(f"the LiDAR did not come back within {timeout_s:g} s: {no}") from no
            time.sleep(TRY_AGAIN_S)

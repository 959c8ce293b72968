"""The sensor's factory calibration: run, kept, and loaded again."""

from collections.abc import Callable
from pathlib import Path

from devices.captures import DeviceLost
from devices.tmf882x.attached import Attached
from devices.tmf882x.calibration_page import CalibrationPage, save_pages
from devices.tmf882x.connection import Connection
from devices.tmf882x.dialogue import ask
from devices.tmf882x.start import read_pages
from recordings.refusal import Refusal


class FactoryCalibration:
    """What a `Tmf882x` can do about its factory calibration; part of it."""

    _attached: Attached
    _running: Connection | None
    _stop: Callable[[], None]

    def calibrate_factory(self, path: str | Path | None = None) -> list[CalibrationPage]:
        """Run the sensor's factory calibration, and save its pages to `path` if there is one.

        It is to be run in the final housing with nothing within 40 cm, in little light (datasheet). The sensor uses
        it until it is reset; a firmware must be compiled with the pages to load them at its start.
        """
        link = self._commanded()
        answer = ask(link.reader, "f", state="stopped")
        if "Fact Cal" not in answer.lines or answer.errors:
            raise DeviceLost(f"the LiDAR was not calibrated: {'; '.join(answer.errors) or 'it did not begin'}")
        pages = self._attached.calibrated(read_pages(link.reader))
        if path is not None:
            save_pages(pages, path)
        return pages

    def load_factory_calibration(self) -> list[CalibrationPage]:
        """Have the firmware load the pages that it was compiled with; returns what the sensor then has."""
        link = self._commanded()
        if "Set fact cal" not in ask(link.reader, "r", state="stopped").lines:
            raise DeviceLost("the LiDAR did not load the factory calibration that its firmware was compiled with")
        return self._attached.calibrated(read_pages(link.reader))

    def _commanded(self) -> Connection:
        """A connection to firmware that takes commands, at rest."""
        link = self._attached.link
        if link.started is None:
            raise Refusal(f"the firmware at {link.port} takes no commands; load the reference firmware onto the board")
        if self._running is link:
            self._stop()
        return link

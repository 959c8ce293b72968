"""The lines between two result lines: the sets of histograms of one capture, or what is wrong with them."""

import numpy as np

from recordings.importers.tmf882x.lines import BINS, CHANNELS, LINES, PLANES, RawLine


class Gatherer:
    """Takes lines of histograms in the order they come; only all of them in the sensor's own order make a capture.

    A measurement cannot be picked up again in its middle: no line says which set, or which measurement, it is of. So
    after a fault the rest is passed over, to the next result line.
    """

    def __init__(self, sets: int) -> None:
        self._expected = sets * LINES
        self.start()

    def start(self) -> None:
        """Forget what came, and begin with line 0."""
        self._values: list[np.ndarray] = []
        self._address: int | None = None
        self.fault: str | None = None
        self.any = False

    def add(self, line: RawLine) -> None:
        """One more line."""
        expected = len(self._values) % LINES
        if not self.any:
            self._address = line.address
        if self.fault is None:
            if line.index != expected or len(self._values) == self._expected:
                began = "began in the middle" if not self.any else "a line is missing, twice there or out of order"
                self.fault = began
            elif line.address != self._address:
                self.fault = "lines of two sensors"
            elif line.skipped:
                self.fault = "partial histograms"
            else:
                self._values.append(line.values)
        self.any = True

    def finish(self, address: int | None) -> np.ndarray | None:
        """(sets, 10, 128) uint32 at the result line of a sensor, or None and `fault` says why."""
        if self.fault is None and len(self._values) != self._expected:
            self.fault = "a line is missing, twice there or out of order" if self.any else "no histograms"
        if self.fault is None and address not in (None, self._address):
            self.fault = "lines of two sensors"
        if self.fault is not None:
            return None
        planes = np.stack(self._values).reshape(-1, PLANES, CHANNELS, BINS).astype(np.uint32)
        return planes[:, 0] | planes[:, 1] << 8 | planes[:, 2] << 16

"""The reference firmware, ams Arduino driver 1.14 as modified: commands in, bytes out, each at its time.

Quirks are kept, since a driver must survive them: `E` resets to the mode of the TMF8828, which the image for the
smaller sensors then refuses; `c` runs past the end of the table of settings; `O` and `o` change their variable whatever
the state is.
"""

from collections import deque

import numpy as np

from devices.emulated.tmf882x import texts
from devices.emulated.tmf882x.chip import ANY_CHIP, Chip
from devices.emulated.tmf882x.enabled import Enabled
from devices.emulated.tmf882x.measuring import Measuring
from devices.emulated.tmf882x.outbox import Outbox
from devices.emulated.tmf882x.source import Source, Wall

DISABLED, STANDBY, STOPPED, MEASURE = "disabled", "standby", "stopped", "measure"
# How long the download of an image over I2C takes, seconds.
DOWNLOAD_S = 1.0
COMMANDS = range(33, 126)


class Firmware:
    """A sensor and its microcontroller; their clock is the `now` of each call, seconds, never less than before.

    source: what the sensor sees; None for a wall. rng: of what nobody knows, such as memory past the end of a table.
    """

    baud = 2_000_000

    def __init__(self, source: Source | None, rng: np.random.Generator, chip: Chip = ANY_CHIP) -> None:
        self.chip, self.rng = chip, rng
        self.out = Outbox(self.baud)
        self.measuring = Measuring(source or Wall(rng), chip, self.out)
        self._typed: deque[str] = deque()
        self._busy_until = float("-inf")
        self.boot(0.0)

    def boot(self, now: float) -> None:
        """As after power came: all settings are lost, help is printed."""
        self.measuring.stop()
        self.out.clear(now)
        self._typed.clear()
        self._busy_until = now
        self.enabled = Enabled(self)
        self.state = DISABLED
        self.say(texts.HELP)

    def write(self, data: bytes, now: float) -> None:
        """Characters that arrive."""
        self._typed.extend(chr(byte) for byte in data if byte in COMMANDS)
        self._obey(now)

    def take(self, now: float) -> list[bytes]:
        """What was sent by `now`, a line each."""
        out = []
        while True:
            self._obey(now)
            out += self.out.take(now)
            if not self.measuring.advance(now):
                return out

    @property
    def next_due(self) -> float | None:
        """When there will be something to take; None if nothing happens by itself."""
        waiting = [self.out.next_due, self.measuring.next_due, self._busy_until if self._typed else None]
        return min((due for due in waiting if due is not None), default=None)

    def say(self, lines: list[str], after: float = 0.0) -> None:
        """Print, `after` seconds of work from now."""
        self._busy_until += after
        for line in lines:
            self.out.put(line.encode("latin-1") + b"\n", self._busy_until)

    def _obey(self, now: float) -> None:
        """Commands that are not held up by one before them."""
        while self._typed and self._busy_until <= now:
            self._busy_until = now
            command = self._typed.popleft()
            # The firmware looks for characters between lines: the line that is being printed goes on to its end.
            if self.state == MEASURE and command in "sdp#":
                self.measuring.stop()
                self.out.cut(now)
            if command == "q":
                continue
            self._one(command)
            self.say([f"TMF88{'28' if self.enabled.mode_8828 else '2x'} state={self.state}"])
            if command == "m" and self.state == MEASURE and not self.measuring.running:
                self.measuring.start(self.enabled.setting, self.enabled.chip_histograms, now)

    def _one(self, command: str) -> None:
        """What a command does, up to the line of the state."""
        if command == "h":
            self.say(texts.HELP)
        elif command == "d":
            self.state = DISABLED
        elif command in "eE":
            self._enable(command)
        elif command == "m" and self.state == STOPPED:
            self.state = MEASURE
        elif command == "s" and self.state == MEASURE:
            self.state = STOPPED
        elif command == "p" and self.state in (MEASURE, STOPPED):
            self.state = STANDBY
        elif command == "w" and self.state == STANDBY:
            self.state = STOPPED
        elif command not in "mspw":
            self.enabled.one(command)

    def _enable(self, command: str) -> None:
        """Switch on and download an image; a sensor that is on only says who it is."""
        if self.state == DISABLED:
            self.say([texts.DOWNLOADED], DOWNLOAD_S)
            self.enabled.reset(image_8828=command == "e")
            self.state = STOPPED
            self.enabled.switch_mode()
            self.enabled.configure()
            self.say(texts.HELP)
        self.say([self.chip.device_line])

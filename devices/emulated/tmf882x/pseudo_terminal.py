"""A serial port that is not there: a pseudo-terminal under a name that stays, though its device changes."""

import os
import termios
import tty
from pathlib import Path

import numpy as np

READ_BYTES = 4096
# Linux names these speeds by numbers of its own.
SPEEDS = {termios.B115200: 115_200, termios.B1000000: 1_000_000, termios.B2000000: 2_000_000}


class PseudoTerminal:
    """The end of the microcontroller; who opens `link` and sets another speed than `baud` hears noise, and makes it."""

    def __init__(self, link: Path, baud: int, rng: np.random.Generator) -> None:
        self._link, self._baud, self._rng = link, baud, rng
        self._ours, self._theirs = os.openpty()
        tty.setraw(self._theirs)
        shape = termios.tcgetattr(self._theirs)
        shape[4] = shape[5] = next(code for code, speed in SPEEDS.items() if speed == baud)
        termios.tcsetattr(self._theirs, termios.TCSANOW, shape)
        os.set_blocking(self._ours, False)
        aside = link.with_name(f".{link.name}.{os.getpid()}.aside")
        aside.symlink_to(os.ttyname(self._theirs))
        os.replace(aside, link)

    def fileno(self) -> int:
        """For `select`."""
        return self._ours

    def read(self) -> bytes:
        """What was typed."""
        return self._heard(os.read(self._ours, READ_BYTES))

    def write(self, data: bytes) -> bytes:
        """Send what goes in; returns the rest."""
        try:
            return data[os.write(self._ours, self._heard(data)) :]
        except BlockingIOError:
            return data

    def close(self) -> None:
        """The port goes away, as it does where a cable is pulled."""
        self._link.unlink(missing_ok=True)
        os.close(self._ours)
        os.close(self._theirs)

    def _heard(self, data: bytes) -> bytes:
        """Bytes as they are at the other end."""
        if SPEEDS.get(termios.tcgetattr(self._theirs)[5]) == self._baud:
            return data
        return self._rng.integers(0, 256, len(data), np.uint8).tobytes()

"""The dashboard of a UR controller: what state it is in, in text; and the few orders a scan may give.

Universal Robots, "Dashboard Server e-Series" and "CB-Series"; port 29999, one line for each line.
"""

import socket
from contextlib import suppress

PORT = 29999
SILENT_S = 3.0


class Dashboard:
    """A connection; raises OSError where nobody answers."""

    def __init__(self, address: str, wait_s: float = SILENT_S) -> None:
        self._socket = socket.create_connection((address, PORT), timeout=wait_s)
        self._lines = self._socket.makefile("r", encoding="utf-8", errors="replace", newline="\n")
        self._answer()  # It greets whoever comes.

    def ask(self, line: str) -> str:
        """What it says to a line."""
        self._socket.sendall(line.encode() + b"\n")
        return self._answer()

    def value(self, line: str) -> str:
        """What it says after the colon, as in "Robotmode: RUNNING"."""
        return self.ask(line).rpartition(":")[2].strip()

    @property
    def remote(self) -> bool:
        """Whether programs may come over the network; CB-Series have no such mode and always take them."""
        return self.ask("is in remote control") != "false"

    def close(self) -> None:
        """Hang up."""
        with suppress(OSError):
            self._lines.close()
            self._socket.close()

    def _answer(self) -> str:
        line = self._lines.readline()
        if not line.endswith("\n"):
            raise ConnectionError("the dashboard hung up")
        return line.strip()

"""Orders to a rehearsal that runs, a line of text each: put the patch on, pull the cable, press the stop."""

import contextlib
import os
import socket
import socketserver
import threading
from collections.abc import Callable, Mapping
from pathlib import Path

from devices.captures import DeviceLost

# Enough for any order, and whoever sends more is somebody else.
MOST_BYTES = 4096
PATIENCE_S = 30.0
DONE = "done"


class Control:
    """Listens on a Unix-domain socket at `path` for the first words of orders; the rest of a line are their words.

    orders: name -> what is done with the words; what it returns is the answer, "done" where it is None.
    """

    def __init__(self, path: str | Path, orders: Mapping[str, Callable[..., str | None]]) -> None:
        class Handler(socketserver.StreamRequestHandler):
            def handle(self) -> None:
                for line in iter(lambda: self.rfile.readline(MOST_BYTES), b""):
                    answer = _obeyed(line.decode("utf-8", "replace"), orders)
                    self.wfile.write(answer.encode() + b"\n")

        self._path = Path(path)
        self._server = socketserver.ThreadingUnixStreamServer(str(path), Handler)
        self._server.daemon_threads = True
        # Only whoever runs the rehearsal may play tricks on it.
        os.chmod(path, 0o600)
        threading.Thread(target=self._server.serve_forever, name="control", daemon=True).start()

    def close(self) -> None:
        """Listen no more."""
        self._server.shutdown()
        self._server.server_close()
        self._path.unlink(missing_ok=True)


def order(path: str | Path, line: str) -> str:
    """Send an order to the rehearsal that listens at `path`; its answer. Raises `DeviceLost` where nobody listens."""
    try:
        with socket.socket(socket.AF_UNIX) as channel:
            channel.settimeout(PATIENCE_S)
            channel.connect(str(path))
            with channel.makefile("rwb") as file:
                file.write(line.encode() + b"\n")
                file.flush()
                return file.readline(MOST_BYTES).decode().rstrip("\n")
    except OSError as wrong:
        raise DeviceLost(f"no rehearsal listens at {path} ({wrong.strerror or wrong})") from None


class RehearsedPerson:
    """Puts the patch on its holder in a rehearsal, or takes it off, when asked."""

    def __init__(self, path: str | Path) -> None:
        self._path = path

    def show(self, patch: bool) -> None:
        """Have it done; the rehearsal answers once it is."""
        with contextlib.suppress(DeviceLost):  # whoever looks for the patch next will say what is wrong
            order(self._path, f"patch {'on' if patch else 'off'}")


def _obeyed(line: str, orders: Mapping[str, Callable[..., str | None]]) -> str:
    """The answer to a line."""
    name, *words = line.split() or [""]
    if name not in orders:
        return f"unknown order {name!r}, expected one of {', '.join(orders)}"
    try:
        return orders[name](*words) or DONE
    except (TypeError, ValueError) as wrong:
        return f"{name}: {wrong}"

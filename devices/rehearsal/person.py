"""The person beside a rehearsed arm, who releases it a while after it was stopped."""

import socket
import threading
import time

from devices.emulated.ur.arm import EmulatedController
from devices.emulated.ur.safety import NORMAL, PROTECTIVE_STOP

DASHBOARD = 29999
LOOKED_EVERY_S = 0.05
PATIENCE_S = 5.0


class Person:
    """Watches an arm in a thread until closed; after_s: how long it stays stopped, seconds of its own clock."""

    def __init__(self, arm: EmulatedController, after_s: float) -> None:
        self._arm, self._after_s, self._over = arm, after_s, threading.Event()
        self._thread = threading.Thread(target=self._watch, name="person", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Go home."""
        self._over.set()
        self._thread.join()

    def _watch(self) -> None:
        since: float | None = None
        while not self._over.wait(LOOKED_EVERY_S):
            mode = self._arm.state()["safety_mode"]
            now = time.monotonic()
            since = None if mode == NORMAL else now if since is None else since
            if since is not None and (now - since) * self._arm.speed >= self._after_s:
                self._release(mode)

    def _release(self, mode: int) -> None:
        """At the pendant: what lets an arm move again."""
        if mode != PROTECTIVE_STOP:
            self._arm.interrupt("released")
            self._press("power on", "brake release")
        else:
            self._press("unlock protective stop")

    def _press(self, *orders: str) -> None:
        """Orders to the controller's dashboard, one answer each."""
        with (
            socket.create_connection((self._arm.host, DASHBOARD), PATIENCE_S) as pendant,
            pendant.makefile("rwb") as line,
        ):
            line.readline()
            for order in orders:
                line.write(order.encode() + b"\n")
                line.flush()
                line.readline()

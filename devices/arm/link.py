"""The line to a UR controller, in a process that can be ended where it hangs."""

import json
import os
import select
import subprocess
import sys
import threading
import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from devices.captures import DeviceLost

# Commands answer within milliseconds; ur_rtde waits 3 s for the controller to be ready.
ANSWERS_S, CONNECTS_S, ENDS_S = 4.0, 15.0, 3.0
# States come at least 125 times a second.
SILENT_S = 2.0


@dataclass(frozen=True, eq=False)
class State:
    """What a controller streams, under the names of the RTDE guide.

    time_s: the controller's clock. pose: (6,) of the tool. speed: (6,) of the tool. joints: (6,) radians.
    operating: whether the program still works on the last move.
    """

    time_s: float
    pose: np.ndarray
    speed: np.ndarray
    joints: np.ndarray
    safety_bits: int
    robot_mode: int
    runtime_state: int
    operating: bool


class Link:
    """Asks ur_rtde in another process; safe from any thread. Raises `DeviceLost` where the controller is gone."""

    def __init__(self, address: str, watchdog_s: float) -> None:
        # The watchdog's own process group: an interrupt from the keyboard must reach the scan only.
        self._process = subprocess.Popen(
            [sys.executable, "-m", "devices.arm.rtde_process", address, repr(watchdog_s)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        self._asking, self._heard, self._number = threading.Lock(), b"", 0
        self._last_s, self._fresh = -1.0, time.monotonic()
        with self._asking:
            self._answer(CONNECTS_S)

    def ask(self, verb: str, *arguments: Any) -> Any:
        """What a verb of `devices.arm.rtde_process.Driver` returns."""
        with self._asking:
            self._number += 1
            try:
                self._process.stdin.write(json.dumps([self._number, verb, *arguments]).encode() + b"\n")
                self._process.stdin.flush()
            except (OSError, ValueError):
                raise self._gone("the connection was closed") from None
            return self._answer(ANSWERS_S)

    def state(self, following: bool = True) -> State:
        """The next state that the controller streams, or else the last one."""
        said = self.ask("state", following)
        if said["time_s"] != self._last_s:
            self._last_s, self._fresh = said["time_s"], time.monotonic()
        if not said.pop("connected") or time.monotonic() - self._fresh > SILENT_S:
            raise self._gone("it is silent")
        return State(**{key: np.array(value) if isinstance(value, list) else value for key, value in said.items()})

    def close(self) -> None:
        """Bring the arm to rest, end our program and let go."""
        if self._process.poll() is None:
            self._process.stdin.close()
            try:
                self._process.wait(ENDS_S)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
        self._process.stdout.close()

    def _answer(self, wait_s: float) -> Any:
        end = time.monotonic() + wait_s
        # Whoever was interrupted while it waited has left an answer behind.
        while (said := self._line(end))["number"] != self._number:
            pass
        if "error" in said:
            raise self._gone(said["error"].strip())
        return said.get("said")

    def _line(self, end: float) -> dict[str, Any]:
        while b"\n" not in self._heard:
            ready, _, _ = select.select([self._process.stdout], [], [], max(end - time.monotonic(), 0))
            if not ready:
                raise self._gone("it does not answer")
            read = os.read(self._process.stdout.fileno(), 1 << 16)
            if not read:
                raise self._gone("the connection broke down")
            self._heard += read
        line, _, self._heard = self._heard.partition(b"\n")
        return json.loads(line)

    def _gone(self, why: str) -> DeviceLost:
        """Nothing that was asked for may happen later."""
        self._process.kill()
        self._process.wait()
        return DeviceLost(f"the arm's controller is gone ({why}): check its cable and whether it is on")

"""An arm that is not there, for whoever drives the real one."""

import json
import subprocess
import sys
import threading
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from recordings.refusal import Refusal

# The tool in front of the base and level, away from limits and singularities.
START_JOINTS = tuple(np.radians([0.0, -80.0, 95.0, -15.0, 90.0, 90.0]).tolist())


class EmulatedController:
    """A controller in a process of its own, from `start` (or entering the context) to `close`; safe from any thread.

    A process, because ur_rtde holds Python's lock while it connects. host: an address of this machine; the ports are
    fixed by the clients, so several controllers need several addresses, such as 127.0.0.2. model: as in rig.json.
    start_joints: (6,) radians. speed: how many times faster than real its clock runs; only the watchdog is not hurried.
    stops: number of a move, counted from 1, and what interrupts it half way, as `interrupt` names it.
    Raises `Refusal` where the ports are taken.
    """

    def __init__(
        self,
        host: str = "127.0.0.1",
        model: str = "UR10",
        start_joints: Sequence[float] = START_JOINTS,
        speed: float = 1.0,
        stops: Mapping[int, str] | None = None,
    ) -> None:
        self.host, self.model, self.speed = host, model, speed
        said = {
            "host": host,
            "model": model,
            "joints": json.dumps(np.asarray(start_joints, float).tolist()),
            "speed": repr(float(speed)),
            "stops": json.dumps(dict(stops or {})),
        }
        self._command = [sys.executable, "-m", "devices.emulated.ur"] + [f"--{key}={said[key]}" for key in said]
        self._process: subprocess.Popen | None = None
        self._lock = threading.Lock()

    def start(self) -> "EmulatedController":
        """Serve."""
        self._process = subprocess.Popen(self._command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        if "refusal" in (said := self._heard()):
            self.close()
            raise Refusal(said["refusal"])
        return self

    def close(self) -> None:
        """Stop serving."""
        if self._process is not None:
            self._process.communicate()
            self._process = None

    def __enter__(self) -> "EmulatedController":
        return self.start()

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def joints(self) -> np.ndarray:
        """(6,) radians, where they are now."""
        return np.array(self.state()["joints"])

    @property
    def tool_pose(self) -> np.ndarray:
        """(6,) metres and rotation vector, where the tool is now."""
        return np.array(self.state()["pose"])

    def state(self) -> dict[str, Any]:
        """Joints, tool's pose, whether it moves, count of moves, whether a program runs, safety mode."""
        return self._ask("state")

    def interrupt(self, kind: str) -> None:
        """Bring about what happens in a laboratory: see `devices.emulated.ur.safety.Safety.interrupt`."""
        self._ask(kind)

    def interrupt_move(self, move: int, kind: str) -> None:
        """Have the move that is the `move`-th from now interrupted half way; moves count from 1."""
        self._ask(f"at {move} {kind}")

    def protective_stop(self) -> None:
        """As on a collision."""
        self.interrupt("protective")

    def emergency_stop(self) -> None:
        """The button is pressed."""
        self.interrupt("emergency")

    def _ask(self, order: str) -> dict[str, Any]:
        with self._lock:
            self._process.stdin.write(order.encode() + b"\n")
            self._process.stdin.flush()
            said = self._heard()
        if "error" in said:
            raise ValueError(said["error"])
        return said

    def _heard(self) -> dict[str, Any]:
        line = self._process.stdout.readline()
        if not line:
            raise RuntimeError(f"emulated arm at {self.host}: its process ended with {self._process.wait()}")
        return json.loads(line)

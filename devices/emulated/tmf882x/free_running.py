"""Firmware that takes no commands: UW Graphics' fork, which measures from the moment it has power."""

import numpy as np

from devices.emulated.tmf882x.chip import ANY_CHIP, Chip
from devices.emulated.tmf882x.measuring import RAW, Measuring
from devices.emulated.tmf882x.outbox import Outbox
from devices.emulated.tmf882x.setting import Setting
from devices.emulated.tmf882x.source import Source, Wall

ACTIVE_RANGE = {"long": "6F", "short": "6E"}
# 3 x 3 zones at the datasheet's usual 550 kilo-iterations; what the fork is set to is not in its output.
USUAL = Setting(False, 0, 33, 550, 1, "short")


class FreeRunning:
    """As `Firmware`, for programs that only listen."""

    baud = 1_000_000

    def __init__(
        self, source: Source | None, rng: np.random.Generator, chip: Chip = ANY_CHIP, setting: Setting = USUAL
    ) -> None:
        self._setting = setting
        self._out = Outbox(self.baud)
        self._measuring = Measuring(source or Wall(rng), chip, self._out)
        self.boot(0.0)

    def boot(self, now: float) -> None:
        """As after power came."""
        self._out.clear(now)
        self._out.put(f"Active range: {ACTIVE_RANGE[self._setting.ranging]}\n".encode("ascii"), now)
        self._measuring.start(self._setting, RAW, now)

    def write(self, data: bytes, now: float) -> None:
        """Characters that arrive, and are not listened to."""

    def take(self, now: float) -> list[bytes]:
        """What was sent by `now`, a line each."""
        out = []
        while True:
            out += self._out.take(now)
            if not self._measuring.advance(now):
                return out

    @property
    def next_due(self) -> float | None:
        """When there will be something to take."""
        waiting = [self._out.next_due, self._measuring.next_due]
        return min((due for due in waiting if due is not None), default=None)

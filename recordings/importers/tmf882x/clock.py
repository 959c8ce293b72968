"""Counters of a few bits, counted on: the number of a measurement and the chip's clock."""

import math

# Datasheet DS000693: the counter steps every 200 ns, is 32 bits wide, and its lowest bit says that it is valid.
TICK_S = 200e-9
TICKS = 1 << 32


class Clock:
    """The chip's clock over its wraps, every 859 s.

    Of the times a reading can stand for, the nearest to the one that is expected by the host's clock is taken. A
    reading that was changed on the way therefore spoils no later one, unless it is off by more than half a wrap.
    """

    def __init__(self) -> None:
        self._last: tuple[int, float] | None = None

    def seconds(self, tick: int, host_s: float) -> float:
        """Seconds on the chip's clock; NaN where the reading says it is not valid."""
        if not tick & 1:
            return math.nan
        if self._last is not None:
            last, then_s = self._last
            passed_s = host_s - then_s if math.isfinite(host_s - then_s) else 0.0
            expected = last + max(0, round(passed_s / TICK_S))
            tick = expected + (tick - expected + TICKS // 2) % TICKS - TICKS // 2
        self._last = tick, host_s
        return tick * TICK_S


class Count:
    """A number that the sensor counts modulo `modulus`, counted on."""

    def __init__(self, modulus: int) -> None:
        self._modulus = modulus
        self.last: int | None = None

    def next(self, number: int) -> int:
        """The smallest number after the last one that the sensor can mean."""
        if self.last is None:
            self.last = number
        else:
            self.last += (number - self.last - 1) % self._modulus + 1
        return self.last

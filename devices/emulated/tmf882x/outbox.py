"""Bytes on their way out of a serial line: each has the time at which its last bit has left."""

from collections import deque

BITS_PER_BYTE = 10  # 8N1: a start bit, eight bits, a stop bit


class Outbox:
    """What was printed and is not yet out, oldest first."""

    def __init__(self, baud: int) -> None:
        self._second_per_byte = BITS_PER_BYTE / baud
        self._waiting: deque[tuple[float, float, bytes]] = deque()  # begins, is out, bytes
        self._idle = float("-inf")

    def put(self, data: bytes, at: float) -> float:
        """Print no sooner than `at`, seconds; returns when it will be out."""
        begins = max(at, self._idle)
        self._idle = begins + len(data) * self._second_per_byte
        self._waiting.append((begins, self._idle, data))
        return self._idle

    def take(self, now: float) -> list[bytes]:
        """What is out by `now`."""
        out = []
        while self._waiting and self._waiting[0][1] <= now:
            out.append(self._waiting.popleft()[2])
        return out

    def cut(self, now: float) -> None:
        """Forget what has not begun by `now`; what has begun goes on to its end."""
        while self._waiting and self._waiting[-1][0] > now:
            self._waiting.pop()
        self._idle = self._waiting[-1][1] if self._waiting else now

    def clear(self, now: float) -> None:
        """Forget everything."""
        self._waiting.clear()
        self._idle = now

    @property
    def next_due(self) -> float | None:
        """When the next of them is out; None if nothing waits."""
        return self._waiting[0][1] if self._waiting else None

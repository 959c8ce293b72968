"""A device's clock against the host's, from when its messages arrive.

A message that the device stamped d arrives at h = a + b d + delay, and no delay is below the least one. So the host's
time of a device's time lies along the lower envelope of the points (d, h) (Moon, Skelly and Towsley 1999, "Estimation
and removal of clock skew from network delay measurements", IEEE INFOCOM). How far below the points the true line may
lie is a matter of how thin the delays are there: see `devices/envelope.py`.
"""

import math
from collections import deque
from dataclasses import dataclass

from devices.envelope import Block, posterior
from recordings.refusal import Refusal

BLOCKS = 32  # kept of a whole window, at most twice as many before
FINEST = 2**16  # blocks in a window, before they are joined two by two
FEWEST = 12


def unwrapped(reading: float, period: float, expected: float) -> float:
    """The reading of a counter that starts anew every `period`, as of the turn that is nearest to what is expected."""
    return reading + period * round((expected - reading) / period)


@dataclass(frozen=True)
class Relation:
    """Host's time of a device's time: `host_s + rate (d - device_s)`, over the span that was heard.

    host_s: of the message with the least delay, less the least latency where that is known. skew: rate - 1.
    covariance: (2, 2) of host_s in s^2 and of the rate. systematic_s: half of the range in which the least latency may
    lie, which arrival times alone cannot tell; infinite where nobody said.
    """

    device_s: float
    host_s: float
    skew: float
    covariance: tuple[tuple[float, float], tuple[float, float]]
    systematic_s: float

    def host(self, device_s: float) -> tuple[float, float]:
        """The host's time at which the device's clock shows this, and its standard deviation, seconds."""
        span = device_s - self.device_s
        (offset, both), (_, rate) = self.covariance
        return self.host_s + (1 + self.skew) * span, math.sqrt(offset + 2 * both * span + rate * span**2)

    def device(self, host_s: float) -> tuple[float, float]:
        """What the device's clock shows at this time of the host, and its standard deviation, seconds."""
        device_s = self.device_s + (host_s - self.host_s) / (1 + self.skew)
        return device_s, self.host(device_s)[1] / (1 + self.skew)


@dataclass(frozen=True)
class Offset:
    """What a first clock shows less what a second one shows, at one instant, seconds.

    sigma_s: standard deviation by the scatter of arrivals. systematic_s: at most this much besides, from latencies that
    arrivals do not tell.
    """

    offset_s: float
    sigma_s: float
    systematic_s: float


def between(first: Relation, second: Relation, host_s: float) -> Offset:
    """How far two devices' clocks are apart at a time of the host; their delays are taken to be independent."""
    (one, one_sigma), (two, two_sigma) = first.device(host_s), second.device(host_s)
    return Offset(one - two, math.hypot(one_sigma, two_sigma), first.systematic_s + second.systematic_s)


class DeviceClock:
    """Hears when a device's messages arrive; keeps a bounded number of points, whatever the number of messages.

    name: in refusals. window_s: how long back messages count; a clock's rate must be steady for that long (that of an
    RC oscillator follows its temperature). latency_s: lowest and highest value that the least latency may have. Where
    the messages' period is a multiple of a polling interval, their delays drift through it together and shift or tilt
    the line by up to that interval either way, unseen: widen both ends by it. A device that was opened anew needs a
    clock of its own here, for its time may have begun anew.
    """

    def __init__(self, name: str, window_s: float = 120.0, latency_s: tuple[float, float] = (0.0, math.inf)) -> None:
        self.name = name
        self._coarsest_s = window_s / BLOCKS
        self._block_s = window_s / FINEST
        self._latency = latency_s
        self._blocks: deque[Block] = deque()
        self._reads: deque[tuple[float, float, float]] = deque(maxlen=BLOCKS)
        self._zero: tuple[float, float] | None = None

    def heard(self, device_s: float, host_s: float) -> None:
        """A message stamped `device_s` (not wrapping) arrived at `host_s`; one without a stamp (NaN) is passed over."""
        if not (math.isfinite(device_s) and math.isfinite(host_s)):
            return
        if self._zero is None:
            self._zero = device_s, host_s
        x = device_s - self._zero[0]
        y = host_s - self._zero[1] - x
        index = math.floor(x / self._block_s)
        if not self._blocks or index > self._blocks[-1].index:
            self._blocks.append(Block(index))
        if index == self._blocks[-1].index:  # a message that comes later than all of a newer block says little
            self._blocks[-1].add(x, y)
        while len(self._blocks) > 2 * BLOCKS and self._block_s < self._coarsest_s:
            self._join()
        while self._blocks[0].index <= self._blocks[-1].index - self._most():
            self._blocks.popleft()

    def _most(self) -> int:
        """Indices that the window spans."""
        return math.ceil(self._coarsest_s * BLOCKS / self._block_s)

    def _join(self) -> None:
        """Blocks of twice the length."""
        self._block_s *= 2
        joined: deque[Block] = deque()
        for block in self._blocks:
            if joined and joined[-1].index == block.index // 2:
                joined[-1].take(block)
            else:
                joined.append(Block(block.index // 2, block.count, block.hull))
        self._blocks = joined

    def asked(self, before_s: float, device_s: float, after_s: float) -> None:
        """The device's clock was asked, and showed `device_s` at some time between two of the host's.

        That bounds the least latency from both sides, as a question and its answer bound an offset in Cristian's
        algorithm (1989, "Probabilistic clock synchronization").
        """
        if math.isfinite(device_s) and before_s <= after_s:
            self._reads.append((before_s, device_s, after_s))

    def relation(self) -> Relation:
        """The relation now; `Refusal` before some messages were heard."""
        count = sum(block.count for block in self._blocks)
        if count < FEWEST or self._zero is None:
            raise Refusal(f"the clock of the {self.name} was heard {count} times, expected at least {FEWEST}")
        middle, (value, rate), covariance = posterior(list(self._blocks))
        least = Relation(
            float(middle + self._zero[0]),
            float(middle + value + self._zero[1]),
            float(rate),
            tuple(map(tuple, covariance.tolist())),
            0.0,
        )
        low, high = self._least_latency(least)
        shift = (low + high) / 2 if math.isfinite(high) else low
        return Relation(least.device_s, least.host_s - shift, least.skew, least.covariance, high - shift)

    def _least_latency(self, least: Relation) -> tuple[float, float]:
        low, high = self._latency
        oldest = self._zero[0] + self._blocks[0].index * self._block_s
        for before, device_s, after in (read for read in self._reads if read[1] >= oldest):
            at, sigma = least.host(device_s)
            low, high = max(low, at - after - 2 * sigma), min(high, at - before + 2 * sigma)
        # Bounds that contradict one another by less than their own error meet half way.
        return (low, high) if low <= high else ((low + high) / 2, (low + high) / 2)

"""How much a search may cost: counted in what it asks for, not in seconds, so that it ends alike on every machine."""

import threading
from dataclasses import dataclass, field

# Renderings after which nothing more is begun that a verdict can do without; of a real recording of 128 frames, in
# which nothing fits, after about five minutes of a slow core.
MOST_RENDERINGS = 6000
# Part of that by which what was begun before may exceed it; then it is finished where it leads alone.
EXCESS = 0.25
# What a rendering takes goes by its pixels, which are added up, and by the knots of its zones' lattices, on which light
# is moved and from which it goes into bins (5 to 14 ms of frames by zones by bins that differ by eight). One of so much
# counts as one, half of 96 frames of 106 × 60 pixels and 9 × 128 bins; more counts as one, less as a part of it, of
# which so much goes into what has to be done in any case.
PIXEL, KNOT, WHOLE, LEAST = 0.4, 0.25, 360_000, 0.3
# To read a pixel of maps where they have moved takes as long as so many of these, to look for a pulse in a cell as so
# many for each bin of its length; to carry light along, as so many renderings.
READING, LOOKING, CARRYING = 10, 0.35, 10.0


@dataclass
class Work:
    """What was asked of a simulation. renderings: how many, by size, kept from before or not; what is kept, once."""

    renderings: float = 0.0
    _made: set[tuple] = field(default_factory=set)
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def add(self, size: float, read: int = 0, looked: float = 0.0) -> None:
        """One rendering more, of this size. read: pixels of maps that are read for it zone by zone.

        looked: cells in which pulses are looked for, times the bins of one.
        """
        with self._lock:
            self.renderings += _part(size) + (READING * read + LOOKING * looked) / WHOLE

    def draw(self, key: tuple, pixels: int) -> None:
        """Maps of so many pixels are drawn anew, if they were not under this key before."""
        self._make(key, pixels / WHOLE)

    def carry(self, key: tuple, size: float) -> None:
        """Light of a rendering of this size is carried along, likewise."""
        self._make(key, CARRYING * _part(size))

    def _make(self, key: tuple, renderings: float) -> None:
        """What is kept once it was made."""
        with self._lock:
            self.renderings += 0 if key in self._made else renderings
            self._made.add(key)

    @property
    def enough(self) -> bool:
        """Whether nothing more should be begun."""
        return self.renderings > MOST_RENDERINGS

    @property
    def far_beyond(self) -> bool:
        """Whether no more of what was begun should be finished than must be."""
        return self.renderings > (1 + EXCESS) * MOST_RENDERINGS


def size_of(pixels: int, knots: int) -> float:
    """What goes by what there is to render."""
    return PIXEL * pixels + KNOT * knots


def _part(size: float) -> float:
    """What a rendering of this size takes, as part of a whole."""
    return min(max(size / WHOLE, LEAST), 1.0)

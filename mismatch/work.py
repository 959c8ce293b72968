"""How much a search may cost: counted in what it asks for, not in seconds, so that it ends alike on every machine."""

import threading
from dataclasses import dataclass, field

# Renderings after which nothing more is begun that a verdict can do without. Of 227 recordings of an independent set 14
# took more, 11 of them of causes that are unknown.
MOST_RENDERINGS = 6000
# Pixels and cells of what counts as one rendering, half of 96 frames of 106 × 60 pixels and 9 × 128 bins; more count as
# one, fewer as a part of it, of which so much goes into what has to be done in any case.
WHOLE, LEAST = 360_000, 0.3
# To read a pixel of maps where they have moved takes as long as so many of these.
READING = 10


@dataclass
class Work:
    """What was asked of a simulation. renderings: how many, by size, kept from before or not, drawings of maps once."""

    renderings: float = 0.0
    _drawings: set[tuple] = field(default_factory=set)
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def add(self, numbers: int, read: int = 0, drawn: int = 0, drawing: tuple = ()) -> None:
        """One rendering more, of so many pixels and cells.

        read: pixels of maps that are read for it zone by zone. drawn: those that are drawn, as `drawing`, anew if they
        were not before.
        """
        with self._lock:
            drawn = 0 if drawing in self._drawings else drawn
            if drawn:
                self._drawings.add(drawing)
            self.renderings += min(max(numbers / WHOLE, LEAST), 1.0) + (READING * read + drawn) / WHOLE

    @property
    def enough(self) -> bool:
        """Whether nothing more should be begun."""
        return self.renderings > MOST_RENDERINGS

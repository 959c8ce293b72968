"""How much a search may cost: counted in what it asks for, not in seconds, so that it ends alike on every machine."""

import threading
from dataclasses import dataclass, field

# Renderings after which nothing more is begun that a verdict can do without. Of 227 recordings of an independent set 14
# took more, 11 of them of causes that are unknown.
MOST_RENDERINGS = 6000


@dataclass
class Work:
    """What was asked of a simulation. renderings: how many, of however many frames, kept from before or not."""

    renderings: int = 0
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def add(self) -> None:
        """One rendering more."""
        with self._lock:
            self.renderings += 1

    @property
    def enough(self) -> bool:
        """Whether nothing more should be begun."""
        return self.renderings > MOST_RENDERINGS

"""What forms change, remembered from an earlier fit: enough to tell which promise nothing beside a later one."""

import threading
from collections.abc import Callable, Hashable
from dataclasses import dataclass, field

import numpy as np

# Numbers that are kept at most, of four bytes each.
MOST_NUMBERS = 1 << 25
# Part of all counts by which a later fit may differ from the earlier for changes to be much the same.
MUCH_THE_SAME = 0.2


@dataclass
class Remembered:
    """Changes of expected counts by what made them, beside counts that were expected without."""

    beside: np.ndarray | None = None
    changes: dict[Hashable, np.ndarray] = field(default_factory=dict)
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def beginning(self, expected: np.ndarray) -> bool:
        """Whether what is remembered is of use beside these counts (F, P, T); if not it is forgotten."""
        if self.beside is not None and np.abs(expected - self.beside).sum() < MUCH_THE_SAME * self.beside.sum():
            return True
        self.beside, self.changes = expected, {}
        return False

    def keep(self, key: Hashable, made: Callable[[], np.ndarray]) -> np.ndarray:
        """A change that is made now, and kept where there is room."""
        change = made()
        with self._lock:
            if sum(one.size for one in self.changes.values()) + change.size <= MOST_NUMBERS:
                self.changes[key] = change.astype(np.float32)
        return change

"""What forms change, remembered from an earlier fit: enough to tell which promise nothing beside a later one."""

import threading
from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from mismatch.simulation import Simulation

# Numbers that are kept at most, of four bytes each.
MOST_NUMBERS = 1 << 25
# Parts of a simulation that are kept at most.
PARTS = 3
# Part of all counts by which a later fit may differ from the earlier for changes to be much the same.
MUCH_THE_SAME = 0.2
# The same for slopes of patches to be as they were, in proportion to counts.
NEAR, LEAST = 0.1, 1e-9


def alike(expected: np.ndarray, beside: np.ndarray, part: float) -> bool:
    """Whether counts (F, P, T) differ from others by less than a part of all."""
    return bool(np.abs(expected - beside).sum() < part * beside.sum())


@dataclass(frozen=True, eq=False)
class Slopes:
    """Of patches, which take a rendering each. beside: (F, P, T) counts expected there. columns: (K, F, P, T)."""

    beside: np.ndarray
    columns: np.ndarray

    def near(self, here: np.ndarray) -> bool:
        """Whether they are of use where counts (F, P, T) are expected."""
        return alike(here, self.beside, NEAR)

    def at(self, here: np.ndarray) -> np.ndarray:
        """(K, F, P, T) as they are there."""
        return self.columns * (here / np.maximum(self.beside, LEAST)).astype(np.float32)


@dataclass
class Remembered:
    """Changes of expected counts by what made them, beside counts that were expected without.

    names: effects that made some of those counts. slopes: of patches there, None if there were none. parts: some of the
    frames, by which they are. clock: where one that was estimated was, (K,) in standard deviations of its numbers, and
    the inverse of their information (K, K).
    """

    beside: np.ndarray | None = None
    names: frozenset[str] = frozenset()
    changes: dict[Hashable, np.ndarray] = field(default_factory=dict)
    slopes: Slopes | None = None
    clock: tuple[np.ndarray, np.ndarray] | None = None
    parts: dict[bytes, "Simulation"] = field(default_factory=dict)
    _numbers: int = 0
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def beginning(self, expected: np.ndarray, names: frozenset[str]) -> bool:
        """Whether what is remembered is of use beside these counts (F, P, T); if not it is forgotten.

        names: effects that make some of them. The same counts, made by another, others change otherwise: light of a
        lamp goes with the detector's gain, pulses of another emitter do not.
        """
        same = names <= self.names or self.names <= names
        if self.beside is not None and same and alike(expected, self.beside, MUCH_THE_SAME):
            return True
        self.beside, self.names, self.changes, self._numbers = expected, names, {}, 0
        return False

    def keep(self, key: Hashable, made: Callable[[], np.ndarray]) -> np.ndarray:
        """A change that is made now, and kept where there is room."""
        change = made()
        with self._lock:
            more = change.size - (self.changes[key].size if key in self.changes else 0)
            if self._numbers + more <= MOST_NUMBERS:
                self._numbers += more
                self.changes[key] = change.astype(np.float32)
        return change

    def frames(self, *parts: np.ndarray) -> np.ndarray:
        """Frames of which these, by index, are some: those that were asked for last, if they are, or just these."""
        asked = np.unique(np.concatenate(parts))
        kept = (np.frombuffer(key, asked.dtype) for key in reversed(self.parts))
        return next((frames for frames in kept if np.isin(asked, frames).all()), asked)

    def part(self, whole: "Simulation", chosen: np.ndarray) -> "Simulation":
        """Some of its frames, by index (N,): the same as the last times they were asked for."""
        key = chosen.tobytes()
        found = self.parts.pop(key) if key in self.parts else whole.of(chosen)
        while len(self.parts) >= PARTS:
            del self.parts[next(iter(self.parts))]
        self.parts[key] = found
        return found

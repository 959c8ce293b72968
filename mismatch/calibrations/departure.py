"""A departure: one way in which two calibrations come to differ, with its few parameters."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mismatch.calibrations.pair import Pair

Shapes = tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class LookAlike:
    """Another cause that leaves much the same, and the capture that tells."""

    id: str
    separated_by: str


@dataclass(frozen=True)
class Strength:
    """A parameter that vanishes at 0. scale: of a strong case, its prior's standard deviation. each: per zone."""

    name: str
    unit: str
    scale: float
    each: bool = False


@dataclass(frozen=True)
class Shape:
    """A parameter that says how, not how much. scale: a step that matters, in `unit`.

    low, high: beyond, it would be another effect, and the fit is not taken.
    """

    name: str
    unit: str
    scale: float
    low: float = -np.inf
    high: float = np.inf


def no_shapes(pair: Pair) -> Shapes:
    """The one try of a departure without shapes."""
    return ((),)


@dataclass(frozen=True, eq=False)
class Departure:
    """How light that the first calibration registered would have been registered by the second.

    id: of the vocabulary of effects. form: which of the effect's forms. stage: the order in which departures compose.
    acts: from the pair, (P, K) counts, strengths by name, shapes by name to (P, K) counts. tries: values of the
    shapes from which a fit begins. seen_as: what can be known of it: a difference of the two, or more.
    """

    id: str
    form: str
    stage: int
    sentence: str
    strengths: tuple[Strength, ...]
    acts: Callable[[Pair, np.ndarray, dict, dict], np.ndarray]
    shapes: tuple[Shape, ...] = ()
    tries: Callable[[Pair], Shapes] = no_shapes
    seen_as: str = "only as a difference: which of the two is at fault, the maps do not tell"
    look_alikes: tuple[LookAlike, ...] = ()

    @property
    def name(self) -> str:
        """Effect and form."""
        return f"{self.id} ({self.form})" if self.form else self.id

    def strength_count(self, zones: int) -> int:
        """Numbers that vanish."""
        return sum(zones if s.each else 1 for s in self.strengths)

    def count(self, zones: int) -> int:
        """Numbers in all: strengths first, then shapes."""
        return self.strength_count(zones) + len(self.shapes)

    def inside(self, x: np.ndarray) -> bool:
        """Whether the shapes among numbers (N,) are what the departure means."""
        shapes = x[len(x) - len(self.shapes) :]
        return all(s.low <= value <= s.high for s, value in zip(self.shapes, shapes, strict=True))

    def labels(self, zones: int) -> list[tuple[str, str]]:
        """Name and unit of each number."""
        names: list[tuple[str, str]] = []
        for s in self.strengths:
            names += [(f"{s.name}[{z}]", s.unit) for z in range(zones)] if s.each else [(s.name, s.unit)]
        return names + [(s.name, s.unit) for s in self.shapes]

    def scales(self, zones: int) -> np.ndarray:
        """(N,) scale of each number."""
        strong = [np.full(zones if s.each else 1, s.scale) for s in self.strengths]
        return np.concatenate([*strong, [s.scale for s in self.shapes]])

    def apply(self, pair: Pair, light: np.ndarray, x: np.ndarray) -> np.ndarray:
        """(P, K) counts with the departure at numbers (N,)."""
        zones, at = len(pair.a), 0
        values: dict = {}
        for s in self.strengths:
            values[s.name] = x[at : at + zones, None] if s.each else x[at]
            at += zones if s.each else 1
        return self.acts(pair, light, values, {s.name: x[at + i] for i, s in enumerate(self.shapes)})

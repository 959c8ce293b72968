"""A parameter of an effect: its unit, its bounds, where a fit begins."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from recordings.refusal import Refusal


@dataclass(frozen=True)
class Parameter:
    """A number that says how strong an effect is, or what it is like.

    unit: as in sensor files; "1" where it has none. low, high: bounds, both admitted; `start` within them is where a
    fit begins and what is taken where nothing is said. vanishes_at: the value at which the effect is not there; None
    for parameters that say what it is like. axis: "zone", "bin", "edge" (that before
    each bin), "zone bin", "zone edge" (those of each zone, zone by zone) or "patch" (`patchwork`) where each of these
    may have its own, else None.
    placed: whether it says where something is, so that a score tells nothing better of a start that the data gave.
    tries: where else a fit may begin, for what one beginning does not reach. power: with which of its powers counts
    change from 0 on, as with the square of a standard deviation. sentence: what it is.
    """

    name: str
    unit: str
    low: float
    high: float
    start: float
    sentence: str
    vanishes_at: float | None = None
    axis: str | None = None
    tries: tuple[float, ...] = ()
    power: float = 1.0
    placed: bool = False

    @property
    def size(self) -> float:
        """A size at which it matters: where it begins, or a part of what is admitted where that is at 0."""
        for value in (self.start, *self.tries):
            if value:
                return abs(value)
        return 0.05 * (self.high - self.low) if np.isfinite(self.high - self.low) else 1.0

    def admits(self, value: float | np.ndarray) -> bool:
        """Whether a number, or each of several, is within bounds."""
        if isinstance(value, float):
            return self.low <= value <= self.high
        return bool(np.all((np.asarray(value) >= self.low) & (np.asarray(value) <= self.high)))

    def checked(self, value: Any, place: str) -> float | np.ndarray:
        """The value as a number, or (P,) numbers; refuses what is none or out of bounds."""
        if isinstance(value, float) and self.low <= value <= self.high:
            return float(value)
        try:
            numbers = np.array(value, float)
        except (TypeError, ValueError):
            raise Refusal(f"{place}: {self.name} is {value!r}, expected a number") from None
        if isinstance(value, bool) or numbers.ndim > (1 if self.axis else 0):
            many = f" or one for each {self.axis}" if self.axis else ""
            raise Refusal(f"{place}: {self.name} is {value!r}, expected one number{many}")
        good = (numbers >= self.low) & (numbers <= self.high)
        if not good.all():
            bad = float(np.atleast_1d(numbers)[~np.atleast_1d(good)][0])
            unit = "" if self.unit == "1" else f" {self.unit}"
            raise Refusal(f"{place}: {self.name} is {bad:g}, expected {self.low:g} to {self.high:g}{unit}")
        return float(numbers) if numbers.ndim == 0 else numbers

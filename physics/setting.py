"""An effect at certain values, and the order in which several of them act."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from physics.parameter import Parameter
from recordings.refusal import Refusal

if TYPE_CHECKING:
    from physics.effect import Effect

# Effects compose in this order, whatever the order in which they are named.
STAGES = ("scene", "optics", "time", "detector", "estimator")

# Of every effect: a mount is knocked, a mode is changed, and from then on it is so.
SINCE = Parameter("since", "s", 0.0, 1e9, 0.0, "When it sets in, after the session began; 0 where it was always there.")
# And: a laser warms up, a mount creeps, a window fogs, and it becomes more, or less, by and by.
GROWS = Parameter("grows", "1/s", -1e3, 1e3, 0.0, "Part of its strength by which it grows in a second.", tries=(0.1,))
STRONG_AT = Parameter("strong_at", "s", 0.0, 1e9, 0.0, "When, after the session began, it is as strong as is said.")
SETTLES = Parameter("settling", "s", 0.0, 1e9, 0.0, "Time constant with which it stops growing; 0 where it goes on.")
OF_EVERY = (SINCE, GROWS, STRONG_AT, SETTLES)


@dataclass(frozen=True, eq=False)
class Setting:
    """An effect that is on.

    values: a number, or (P,) numbers, for each of its parameters and `OF_EVERY`, in its units.
    """

    effect: "Effect"
    values: dict[str, Any] = field(default_factory=dict)

    @property
    def key(self) -> tuple:
        """Equal for two settings that act the same."""
        return (self.effect.id, *((n, np.asarray(v, float).tobytes()) for n, v in sorted(self.values.items())))

    @property
    def since_s(self) -> float:
        """Seconds after the session began from which on it is there."""
        return float(self.values[SINCE.name])

    @property
    def grows(self) -> bool:
        """Whether it becomes more, or less, in the course of the session."""
        return self.values[GROWS.name] != 0

    def degree(self, time_s: np.ndarray) -> np.ndarray:
        """(F,) times as strong as is said that it is at (F,) seconds after the session began, 0 or more."""
        settles_s = self.values[SETTLES.name]
        now, then = (warmed(time, settles_s) for time in (time_s, self.values[STRONG_AT.name]))
        return np.maximum(1 + self.values[GROWS.name] * (now - then), 0.0)

    def times(self, degree: float) -> "Setting":
        """The same, always so many times as strong, as far as bounds admit."""
        values = self.values | {GROWS.name: GROWS.start}
        for p in self.effect.parameters:
            if p.vanishes_at is not None:
                stronger = p.vanishes_at + degree * (np.asarray(values[p.name], float) - p.vanishes_at)
                values[p.name] = np.clip(stronger, p.low, p.high)
        return self.effect.at(**values)

    def with_value(self, name: str, value: Any) -> "Setting":
        """The same with one parameter changed; the value is checked."""
        return self.effect.at(**(self.values | {name: value}))


def warmed(time_s: np.ndarray | float, settles_s: float) -> np.ndarray:
    """(F,) seconds after the session began; of what settles, in how many it would come as far at its first pace."""
    time_s = np.asarray(time_s, float)
    return time_s if settles_s == 0 else -settles_s * np.expm1(-time_s / settles_s)


def in_order(settings: tuple[Setting, ...]) -> tuple[Setting, ...]:
    """Settings in the order in which they compose: by what they act on, then by `order`, then by id."""
    ids = [setting.effect.id for setting in settings]
    for name in ids:
        if ids.count(name) > 1:
            raise Refusal(f"effect {name} is named twice, expected once")
    return tuple(sorted(settings, key=lambda s: (STAGES.index(s.effect.acts_on), s.effect.order, s.effect.id)))

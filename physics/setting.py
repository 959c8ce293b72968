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

# A parameter of every effect: a mount is knocked, a mode is changed, and from then on it is so.
SINCE = Parameter("since", "s", 0.0, 1e9, 0.0, "When it sets in, after the session began; 0 where it was always there.")


@dataclass(frozen=True, eq=False)
class Setting:
    """An effect that is on. values: a number, or (P,) numbers, for each of its parameters and `SINCE`, in its units."""

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

    def with_value(self, name: str, value: Any) -> "Setting":
        """The same with one parameter changed; the value is checked."""
        return self.effect.at(**(self.values | {name: value}))


def in_order(settings: tuple[Setting, ...]) -> tuple[Setting, ...]:
    """Settings in the order in which they compose: by what they act on, then by `order`, then by id."""
    ids = [setting.effect.id for setting in settings]
    for name in ids:
        if ids.count(name) > 1:
            raise Refusal(f"effect {name} is named twice, expected once")
    return tuple(sorted(settings, key=lambda s: (STAGES.index(s.effect.acts_on), s.effect.order, s.effect.id)))

"""What an effect is: a named departure from the nominal model, its parameters, and the step it changes."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from physics.owning import Look, Unseen
from physics.parameter import Parameter
from physics.rendering import NOUNS, Rendering
from physics.setting import OF_EVERY, Setting
from recordings.refusal import Refusal

Values = Mapping[str, Any]


@dataclass(frozen=True)
class LookAlike:
    """Another effect that can be mistaken for this one. separated_by: the capture that tells the two apart."""

    id: str
    separated_by: str


class Effect:
    """One cause. A subclass fills in the class variables and the methods named after what it changes.

    id: public name. acts_on: one of `STAGES` (physics/setting.py); of those that act on the same the one of lower
    `order` comes first.
    sentence: what happens, in one plain sentence. look_alikes: other effects it can be mistaken for.
    forms: groups of parameters that are fitted together, one way for it to be there each; all at once where empty.
    richer: those of the forms that are tried only where another of the effect's was chosen and leaves something.
    untold: those tried only where time zero was estimated. common: those in which zones have no values of their own, as
    fits would take too long. uneven: those in which they have in any case. varied: parameters of which a start tells
    forms alone that vary them. exact: whether anybody would write it so. grows: whether it may become more, or less,
    in the course of a session, and no other name says so.

    The methods, any number of them, are `light`, `footprints`, `clock`, `arrivals`, `background` and `expected`: each
    takes the parameters' values and the `Rendering` so far, and returns that field of it, changed. They draw no random
    numbers, work on all frames at once, are continuous, and leave the field as it was where the parameters vanish. One
    that mixes frames says how far it looks by `reach`.
    """

    id: ClassVar[str]
    acts_on: ClassVar[str]
    sentence: ClassVar[str]
    parameters: ClassVar[tuple[Parameter, ...]]
    look_alikes: ClassVar[tuple[LookAlike, ...]] = ()
    order: ClassVar[int] = 0
    forms: ClassVar[tuple[tuple[str, ...], ...]] = ()
    richer: ClassVar[tuple[tuple[str, ...], ...]] = ()
    untold: ClassVar[tuple[tuple[str, ...], ...]] = ()
    common: ClassVar[tuple[tuple[str, ...], ...]] = ()
    uneven: ClassVar[tuple[tuple[str, ...], ...]] = ()
    varied: ClassVar[tuple[str, ...]] = ()
    exact: ClassVar[bool] = False
    grows: ClassVar[bool] = False

    @property
    def changes(self) -> tuple[str, ...]:
        """Which fields of a rendering it changes."""
        return tuple(noun for noun in NOUNS if hasattr(self, noun))

    @cached_property
    def _by_name(self) -> dict[str, Parameter]:
        """Its parameters, and those of every effect."""
        return {parameter.name: parameter for parameter in (*self.parameters, *OF_EVERY)}

    def parameter(self, name: str) -> Parameter:
        """The parameter of this name."""
        if name not in self._by_name:
            known = ", ".join(self._by_name)
            raise Refusal(f"effect {self.id}: {name!r} is no parameter of it, expected one of {known}")
        return self._by_name[name]

    def at(self, **values: Any) -> Setting:
        """The effect at these values.

        What is not named is at its start, but strengths (parameters that vanish) are not there: where no strength is
        named those of the first form are at their start, where one is named the others are not there.
        """
        named = {name: self.parameter(name).checked(value, f"effect {self.id}") for name, value in values.items()}
        strengths = [p.name for p in self.parameters if p.vanishes_at is not None]
        first = self.forms[0] if self.forms else strengths
        present = named.keys() if named.keys() & set(strengths) else first
        rest = {
            p.name: p.start if p.vanishes_at is None or p.name in present else p.vanishes_at for p in self.parameters
        }
        return Setting(self, rest | {p.name: p.start for p in OF_EVERY} | named)

    def vanished(self) -> Setting:
        """The effect where it is not there."""
        gone = {p.name: p.vanishes_at for p in self.parameters if p.vanishes_at is not None}
        return self.at(**gone)

    def reach(self, values: Values) -> tuple[float, float]:
        """How many seconds before and after a frame it looks at other frames; (0, 0) where each is by itself.

        Whoever renders frames in batches gives it all of these, and the first frame at or beyond either end.
        """
        return 0.0, 0.0

    def reaches(self, values: Values) -> bool:
        """Whether it looks at other frames at all."""
        return any(seconds > 0 for seconds in self.reach(values))

    def mixes(self, values: Values) -> bool:
        """Whether it does so beside what the light of some frames knows of all: which surface is which."""
        return self.reaches(values)

    def in_scene(self, values: Values) -> bool:
        """Whether, at these values, it changes what the scene sends back or where zones look."""
        return bool({"light", "footprints"} & set(self.changes))

    def moves_maps(self, values: Values) -> tuple[bool, bool]:
        """Whether, at these values, it moves maps by another amount from zone to zone, and from frame to frame."""
        return False, False

    def moves_light(self, values: Values) -> bool:
        """Whether, at these values, it moves light that was added up, which takes a lattice fine enough for that."""
        return False

    def redraws_maps(self, values: Values) -> bool:
        """Whether, at these values, it draws maps anew, all of their pixels."""
        return False

    def carries(self, values: Values) -> bool:
        """Whether, at these values, it carries light along with what moves, which takes as long as many renderings."""
        return False

    def looks(self, values: Values) -> bool:
        """Whether, at these values, it looks at what was recorded to see where things are in each frame."""
        return False

    def look(self, values: Values, rendering: Rendering) -> Look:
        """What it saw there. rendering: with `expected` counts as they are without it, and those that were recorded."""
        raise NotImplementedError  # Only an effect that `looks` is asked, and it has its own.

    def owns_up(self, values: Values) -> bool:
        """Whether, at these values, counts are uncertain as nobody saw what the model would have to know."""
        return False

    def unseen(self, values: Values, rendering: Rendering) -> Unseen:
        """By how much they are."""
        raise NotImplementedError  # Only an effect that `owns_up` is asked, and it has its own.

    def at_random(self, values: Values, rendering: Rendering, rng: np.random.Generator) -> np.ndarray:
        """(F, P, T) expected counts with things somewhere, by chance, in each frame.

        rendering: as for `look`, or as if nothing had been recorded.
        """
        raise NotImplementedError  # Only an effect that `looks` is asked, and it has its own.

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, Any]]:
        """Where a fit may begin, as the data suggest: values of some parameters, numbers or (P,), each a dictionary.

        excess: (F, P, T) recorded less expected counts. For effects that show at one place out of many.
        """
        return []

    def strained(self, values: Values, rendering: Rendering) -> bool:
        """Whether values that are admitted stretch what the effect means, so that another name would be better."""
        return False

    def contradiction(self, values: Values, rendering: Rendering) -> str | None:
        """Why such values, if they fit, say that it is not this effect but something that looks alike; None if not."""
        return None

    def apply(self, noun: str, values: Values, rendering: Rendering) -> Any:
        """The field `noun` of the rendering, changed."""
        return getattr(self, noun)(values, rendering)

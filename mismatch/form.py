"""A form of an effect: which of its parameters are fitted, and whether each zone or bin has its own."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np

from mismatch.coordinate import to_coordinate, to_value
from physics.axes import sizes_along
from physics.effect import Effect, Parameter
from physics.effects import all_effects
from physics.setting import GROWS, Setting

# Of what each has a number of its own wherever it is in a form: of these there are many.
DRAWN = ("bin", "edge", "zone bin", "zone edge", "patch")
# What there are more of is not tried: information of numbers, each with each, would take minutes and all memory.
MOST = 2500


@dataclass(frozen=True, eq=False)
class Form:
    """One way in which an effect may be there.

    effect. free: names of fitted parameters. own: those of which each zone (or bin) has its own. start: values of all
    parameters where a fit begins, numbers, or arrays of those in `own` or given. sizes: how many each of `own` has, and
    how many "bin"s there are.
    given: names of parameters that say what the effect is like, which the data gave and no fit varies.
    """

    effect: Effect
    free: tuple[str, ...]
    own: tuple[str, ...]
    start: dict[str, Any]
    sizes: dict[str, int] = field(default_factory=dict)
    given: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """For people: effect, and what is fitted."""
        return f"{self.effect.id}({', '.join(n + '[]' * (n in self.own) for n in self.free)})"

    @property
    def strengths(self) -> tuple[str, ...]:
        """Free parameters that vanish."""
        return tuple(n for n in self.free if self.effect.parameter(n).vanishes_at is not None)

    @property
    def coordinates(self) -> list[tuple[Parameter, int | None]]:
        """What a fit varies: a parameter, and which zone's or bin's, None where all have the same."""
        found = []
        for name in self.free:
            places = range(self.sizes[name]) if name in self.own else (None,)
            found += [(self.effect.parameter(name), place) for place in places]
        return found

    @cached_property
    def begins_alike(self) -> tuple:
        """Equal for forms that begin with the same strengths, of all or of each zone, in the same place."""
        return self.strengths, self.own, self.effect.at(**self.start).key

    @property
    def looks(self) -> bool:
        """Whether its effect, where it begins, looks at what was recorded."""
        return self.effect.looks(self.start)

    def setting(self, x: np.ndarray) -> Setting:
        """The effect at coordinates (N,)."""
        values, at = dict(self.start), 0
        for name in self.free:
            count = self.sizes[name] if name in self.own else 1
            real = to_value(self.effect.parameter(name), x[at : at + count])
            values[name] = real if name in self.own else float(real[0])
            at += count
        return self.effect.at(**values)

    def at_start(self) -> np.ndarray:
        """(N,) coordinates of `start`."""
        return np.array([to_coordinate(p, self.begins(p.name, place)) for p, place in self.coordinates])

    def begins(self, name: str, place: int | None) -> float:
        """Where a parameter begins, that of one zone, bin or edge where each has its own."""
        value = self.start[name]
        return float(value) if np.ndim(value) == 0 else float(value[place])

    def coordinates_of(self, setting: Setting) -> np.ndarray:
        """(N,) coordinates of a setting of this form."""
        parts = [
            np.broadcast_to(np.asarray(setting.values[n], float), self.sizes[n] if n in self.own else 1)
            for n in self.free
        ]
        parameters = [p for p, _ in self.coordinates]
        return np.array([to_coordinate(p, v) for p, v in zip(parameters, np.concatenate(parts), strict=True)])

    def coordinates_from(self, other: "Form", setting: Setting) -> np.ndarray:
        """(N,) coordinates of a setting of another form; what that neither varied nor was given begins as here.

        One value for all begins amid those of zones.
        """
        new = {p.name for p, _ in self.coordinates if p.vanishes_at is None} - {*other.free, *other.given}
        values = setting.values | {name: self.start[name] for name in new}
        values |= {n: float(np.median(values[n])) for n in set(self.free) - set(self.own)}
        return self.coordinates_of(self.effect.at(**values))

    def with_own(self, own: tuple[str, ...]) -> "Form":
        """The same form in which each zone has its own values of these parameters; a fit of it begins elsewhere."""
        return replace(self, own=own)

    def given_as(self, other: "Form") -> "Form":
        """The same form with what `other` was given and it does not vary itself; growing where that grows."""
        given = tuple(name for name in other.given if name not in self.free)
        grows = (GROWS.name,) if GROWS.name in set(other.free) - set(self.free) else ()
        start = self.start | {name: other.start[name] for name in (*given, *grows)}
        return replace(self, free=(*self.free, *grows), start=start, given=given)

    def beginning(self, values: dict[str, Any]) -> "Form | None":
        """The same form begun elsewhere; None where these parameters, or each zone's own, are not in it.

        Nor where they say how strong something is that is not in it, or what only forms that vary it are told, or are
        out of bounds.
        """
        strengths = {parameter.name for parameter in self.effect.parameters if parameter.vanishes_at is not None}
        if (strengths | set(self.effect.varied)) & values.keys() - set(self.free):
            return None
        each = {name for name, value in values.items() if np.ndim(value)}
        if not values.keys() & set(self.free) or each & set(self.free) - set(self.own):
            return None
        given = tuple(n for n in values if n not in self.free and self.effect.parameter(n).vanishes_at is None)
        mine = {name: value for name, value in values.items() if name in (*self.free, *given)}
        if not all(self.effect.parameter(name).admits(value) for name, value in mine.items()):
            return None
        return replace(self, start=self.start | mine, given=given)


def settings_at(forms: tuple[Form, ...], x: np.ndarray) -> tuple[Setting, ...]:
    """Effects at coordinates, log gain first."""
    found, at = [], 1
    for form in forms:
        count = len(form.coordinates)
        found.append(form.setting(x[at : at + count]))
        at += count
    return tuple(found)


def forms_of(effect: Effect, sizes: dict[str, int]) -> Iterator[Form]:
    """Every form in which an effect is tried, at each of the values where a fit may begin.

    sizes: how many "zone"s and "bin"s there are.
    """
    sizes = sizes_along(sizes["zone"], sizes["bin"])
    for names in effect.forms or (tuple(p.name for p in effect.parameters),):
        chosen = [effect.parameter(name) for name in names]
        gone = {p.name: p.vanishes_at for p in effect.parameters if p.vanishes_at is not None}
        rest = {p.name: p.start for p in effect.parameters} | gone
        divided = tuple(p.name for p in chosen if p.axis and p.vanishes_at is not None)
        many = {"bin": sizes["bin"]} | {p.name: sizes[p.axis] for p in chosen if p.axis}
        always = tuple(p.name for p in chosen if p.axis in DRAWN)
        if any(many[name] > MOST for name in always):
            continue
        for values in product(*(p.tries or (p.start,) for p in chosen)):
            start = rest | dict(zip(names, values, strict=True))
            if set(divided) - set(always) and names not in effect.uneven:
                yield Form(effect, names, always, start, many)
            if not set(divided) - set(always) or names not in effect.common:
                yield Form(effect, names, divided, start, many)


def all_forms(sizes: dict[str, int], without: tuple[str, ...] = (), guessed: bool = False) -> list[Form]:
    """All forms of all effects but those named. guessed: whether time zero was estimated from the recording."""
    return [
        form
        for name, effect in sorted(all_effects().items())
        if name not in without
        for form in forms_of(effect, sizes)
        if guessed or form.free not in effect.untold
    ]

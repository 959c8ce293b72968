"""The vocabulary of causes: one file an effect, found by itself; effects from outside come through an entry point.

A file defines `effect`, an instance of a subclass of `physics.effect.Effect`. A package elsewhere offers its own as

    [project.entry-points."difflidar.effects"]
    my_effect = "my_package.my_effect:effect"
"""

import importlib
import pkgutil
from functools import cache
from importlib.metadata import entry_points

from physics.effect import Effect
from physics.setting import STAGES
from recordings.refusal import Refusal

GROUP = "difflidar.effects"


@cache
def all_effects() -> dict[str, Effect]:
    """Every effect that is known, by id: those in this folder and those that installed packages offer."""
    found = {}
    for module in pkgutil.iter_modules(__path__):
        found[module.name] = importlib.import_module(f"{__name__}.{module.name}").effect
    for entry in entry_points(group=GROUP):
        try:
            effect = entry.load()
        except Exception as wrong:  # somebody else's module may fail in any way
            raise Refusal(f"effect {entry.name} of {entry.value} does not load: {wrong}") from None
        fault = fault_of(effect, entry.name)
        if fault or entry.name in found:
            raise Refusal(f"effect {entry.name} of {entry.value} {fault or 'has the id of another effect'}")
        found[entry.name] = effect
    return found


def find_effect(name: str) -> Effect:
    """The effect with this id."""
    known = all_effects()
    if name not in known:
        raise Refusal(f"effect {name!r} is unknown, expected one of {', '.join(sorted(known))}")
    return known[name]


def fault_of(effect: object, name: str) -> str | None:
    """What keeps an object from being the effect of this name, or None."""
    if not isinstance(effect, Effect):
        return f"is {type(effect).__name__}, expected an instance of physics.effect.Effect"
    if getattr(effect, "id", None) != name:
        return f"has the id {getattr(effect, 'id', None)!r}, expected {name!r} as it is offered"
    if getattr(effect, "acts_on", None) not in STAGES:
        return f"acts on {getattr(effect, 'acts_on', None)!r}, expected one of {', '.join(STAGES)}"
    if not effect.changes:
        return "changes nothing, expected a method light, footprints, clock, arrivals, background or expected"
    if all(parameter.vanishes_at is None for parameter in effect.parameters):
        return "never vanishes, expected a parameter with vanishes_at"
    return None

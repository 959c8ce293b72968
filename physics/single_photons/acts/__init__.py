"""How each effect acts on single photons: one file an effect, named by its id, found by itself.

A file defines any of

    world(world, values, rng) -> World              before photons are drawn: geometry, weights, gain, clock
    photons(photons, world, values, rng) -> Photons     laser light under way, before the background is there
    detected(photons, world, values, rng) -> Photons    all that reaches the detector, with its laser shot
    counted(counts, world, values, rng) -> counts       (P, T) int64 of the frame

`values` are the effect's parameters: a number, or (P,) numbers.
"""

import importlib
import pkgutil
from functools import cache
from types import ModuleType

from recordings.refusal import Refusal

HOOKS = ("world", "photons", "detected", "counted")


@cache
def all_acts() -> dict[str, ModuleType]:
    """The module of every effect that acts on single photons, by the effect's id."""
    names = [module.name for module in pkgutil.iter_modules(__path__)]
    return {name: importlib.import_module(f"{__name__}.{name}") for name in names}


def find_act(name: str) -> ModuleType:
    """The act of the effect with this id."""
    known = all_acts()
    if name not in known:
        raise Refusal(f"effect {name!r} has no act on single photons, expected one of {', '.join(sorted(known))}")
    return known[name]

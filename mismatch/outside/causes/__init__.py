"""Descriptions of causes outside the library: one file each, found by itself, which defines `effect`.

None is ever named as an effect. Each is the plainest formula of something that sensors, firmware or cameras are known
to do and that, to first order, looks like an effect of the library.
"""

import importlib
import pkgutil
from functools import cache

from physics.effect import Effect


@cache
def all_outside() -> dict[str, Effect]:
    """Every cause outside the library that can be told from its effects, by id."""
    modules = (importlib.import_module(f"{__name__}.{found.name}") for found in pkgutil.iter_modules(__path__))
    return {module.effect.id: module.effect for module in modules}

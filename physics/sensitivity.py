"""How expected counts change with the effects' parameters: central differences, which respect every bound."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from physics.effect import Parameter
from physics.setting import Setting

# Of a parameter's size: far above the rounding of single-precision light, far below what bends the model.
RELATIVE_STEP = 1e-3

Model = Callable[[tuple[Setting, ...]], np.ndarray]


@dataclass(frozen=True, eq=False)
class Derivative:
    """Change of expected counts with one parameter of one effect.

    zone: whose parameter it is where each zone has its own, else None. by_unit: (F, P, T) counts per unit.
    """

    effect: str
    parameter: str
    zone: int | None
    by_unit: np.ndarray


def derivatives(model: Model, settings: tuple[Setting, ...]) -> list[Derivative]:
    """The derivative of `model`, a function of settings, with every parameter of every setting.

    Second-order central differences, one-sided of second order where a bound is nearer than a step.
    """
    found = []
    for i, setting in enumerate(settings):
        for parameter in setting.effect.parameters:
            value = np.asarray(setting.values[parameter.name], float)
            for zone in (None,) if value.ndim == 0 else range(len(value)):

                def at(there: float, i=i, setting=setting, name=parameter.name, value=value, zone=zone) -> np.ndarray:
                    moved = there if zone is None else np.where(np.arange(len(value)) == zone, there, value)
                    return model((*settings[:i], setting.with_value(name, moved), *settings[i + 1 :]))

                here = float(value if zone is None else value[zone])
                by_unit = difference(at, here, parameter)
                found.append(Derivative(setting.effect.id, parameter.name, zone, by_unit))
    return found


def difference(at: Callable[[float], np.ndarray], here: float, parameter: Parameter) -> np.ndarray:
    """The derivative of `at` by the value of the parameter, at `here`."""
    step = RELATIVE_STEP * max(abs(here), parameter.size)
    if here - step >= parameter.low and here + step <= parameter.high:
        return (at(here + step) - at(here - step)) / (2 * step)
    step = step if here + 2 * step <= parameter.high else -step
    return (4 * at(here + step) - 3 * at(here) - at(here + 2 * step)) / (2 * step)

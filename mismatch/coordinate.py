"""A parameter as a fit varies it: a number of order one, in proportion to which counts change."""

import numpy as np

from physics.effect import Parameter

# Parameters bounded above zero that range over more than this are fitted by their logarithm.
LOGARITHMIC = 30.0
# A coordinate of which the value is a root, where it is 0: the value grows infinitely fast there.
LEAST = 1e-3


def logarithmic(parameter: Parameter) -> bool:
    """Whether its logarithm is fitted."""
    return parameter.low > 0 and parameter.high > LOGARITHMIC * parameter.low


def to_coordinate(parameter: Parameter, value: float) -> float:
    """A coordinate of order one, in proportion to which counts change."""
    if logarithmic(parameter):
        return float(np.log(value / parameter.start))
    part = value / parameter.size
    return float(part**parameter.power) if parameter.power != 1 else part


def to_value(parameter: Parameter, x: float | np.ndarray) -> float | np.ndarray:
    """The value at a coordinate, within bounds; or each at its own."""
    if logarithmic(parameter):
        value = parameter.start * np.exp(x)
    else:
        value = parameter.size * (np.maximum(x, 0.0) ** (1 / parameter.power) if parameter.power != 1 else x)
    return np.clip(value, parameter.low, parameter.high)


def slope_of(parameter: Parameter, x: float) -> float:
    """By how much the value grows for each unit of its coordinate."""
    if logarithmic(parameter):
        return abs(to_value(parameter, x))
    if parameter.power == 1:
        return parameter.size
    return parameter.size / parameter.power * max(x, LEAST) ** (1 / parameter.power - 1)


def error_of(parameter: Parameter, x: float, sigma: float) -> float:
    """How far, at most, a value is from that of a coordinate x where the coordinate is off by `sigma` either way."""
    value = to_value(parameter, x)
    return max(abs(to_value(parameter, x + side * sigma) - value) for side in (-1.0, 1.0))


def bounds(parameter: Parameter) -> tuple[float, float]:
    """Of its coordinate."""
    ends = [to_coordinate(parameter, end) for end in (parameter.low, parameter.high)]
    return min(ends), max(ends)

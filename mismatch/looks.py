"""Effects that look at the recording to see where things are in each frame: what they own up to, in a fit."""

import numpy as np

from mismatch.columns import Rows
from mismatch.coordinate import slope_of
from mismatch.form import Form, settings_at
from mismatch.noise import Nuisances
from mismatch.simulation import Simulation
from physics.owning import Look
from physics.setting import Setting


def flattery(simulation: Simulation, gain: float, settings: tuple[Setting, ...]) -> float:
    """Deviance by which effects that look at what was recorded fit it better than they have a right to."""
    return sum(look.flattery for look in looks_of(simulation, gain, settings))


def blur(simulation: Simulation, gain: float, settings: tuple[Setting, ...]) -> float:
    """Deviance that is left because where things are stays uncertain."""
    return sum(look.blur for look in looks_of(simulation, gain, settings))


def looks_of(simulation: Simulation, gain: float, settings: tuple[Setting, ...]) -> list[Look]:
    """What each effect that looks has to own up to."""
    return [
        setting.effect.look(setting.values, simulation.without(gain, settings, setting))
        for setting in settings
        if setting.effect.looks(setting.values)
    ]


def deviance_at(nuisances: Nuisances, forms: tuple[Form, ...], x: np.ndarray, expected: np.ndarray) -> float:
    """Of expected counts at coordinates, and what it costs to have looked where things are."""
    return nuisances.deviance(expected) + flattery(nuisances.simulation, float(np.exp(x[0])), settings_at(forms, x))


def equations(
    nuisances: Nuisances,
    forms: tuple[Form, ...],
    x: np.ndarray,
    expected: np.ndarray,
    columns: Rows,
    *,
    nearly: bool = False,
) -> tuple[np.ndarray, np.ndarray]:
    """(N,) score and (N, N) information of coordinates, log gain first. nearly: near enough for a step.

    The likelihood of effects that look is not that of the counts they end up with: its slopes are their own, and its
    curvature is estimated from how these scatter over the frames (Berndt, Hall, Hall and Hausman 1974).
    """
    score, information = nuisances.normal_equations(expected, columns, nearly=nearly)
    settings, simulation = settings_at(forms, x), nuisances.simulation
    at = 1
    for form, setting in zip(forms, settings, strict=True):
        coordinates = form.coordinates
        if setting.effect.looks(setting.values):
            look = setting.effect.look(setting.values, simulation.without(float(np.exp(x[0])), settings, setting))
            each = np.stack(
                [_of_coordinate(look.slopes, *coordinate, x[at + i]) for i, coordinate in enumerate(coordinates)]
            )
            own = slice(at, at + len(coordinates))
            score[own] = each.sum(axis=1)
            information[own], information[:, own] = 0.0, 0.0
            information[own, own] = each @ each.T
        at += len(coordinates)
    return score, information


def _of_coordinate(slopes: dict[str, np.ndarray], parameter, place: int | None, x: float) -> np.ndarray:
    """(F,) derivatives by one coordinate."""
    slope = slopes[parameter.name]
    if slope.ndim == 2:
        slope = slope.sum(axis=1) if place is None else slope[:, place]
    return slope * slope_of(parameter, x)

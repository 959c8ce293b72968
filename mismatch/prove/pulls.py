"""How far estimated parameters lie from true ones, in units of their stated errors."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from mismatch.verdict import Estimate
from physics.effect import Effect


def pulls(effect: Effect, truth: Mapping[str, Any], estimates: Sequence[Estimate]) -> dict[str, np.ndarray]:
    """(estimate - truth) / sigma of each parameter that both sides name and that has an error, (N,) by name.

    truth: a number, or one for each zone, bin or edge. Where only one side tells these apart, nothing is compared. Nor
    is anything where the effect is there in another form: then it is the form that is right or wrong, not its error.
    """
    if not _same_form(effect, truth, {estimate.name.partition("[")[0] for estimate in estimates}):
        return {}
    found: dict[str, list[tuple[int | None, Estimate]]] = {}
    for estimate in estimates:
        name, _, place = estimate.name.partition("[")
        if name in truth and estimate.sigma and (np.ndim(truth[name]) > 0) == bool(place):
            found.setdefault(name, []).append((int(place.rstrip("]")) if place else None, estimate))
    out = {}
    for name, several in found.items():
        values = np.array([estimate.value for _, estimate in several])
        true = np.array([truth[name] if place is None else truth[name][place] for place, _ in several], float)
        if len(values) > 1 and effect.parameter(name).vanishes_at == 1:
            # A factor that all have in common is the recording's gain: only ratios are there to be found.
            true = true * (values.mean() / true.mean())
        out[name] = (values - true) / [estimate.sigma for _, estimate in several]
    return out


def _same_form(effect: Effect, truth: Mapping[str, Any], estimated: set[str]) -> bool:
    """Whether what is estimated is what is there: all that is not as where nobody names it, and no other strength.

    Of a truth that names some parameters only, nothing is known of the others.
    """
    for parameter in effect.parameters:
        if parameter.name not in truth:
            continue
        strength = parameter.vanishes_at is not None
        there = np.any(np.asarray(truth[parameter.name]) != (parameter.vanishes_at if strength else parameter.start))
        if there != (parameter.name in estimated) and (strength or there):
            return False
    return True

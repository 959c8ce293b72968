"""How far estimated parameters lie from true ones, in units of their stated errors."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from mismatch.verdict import Estimate
from physics.effect import Effect


def pulls(effect: Effect, truth: Mapping[str, Any], estimates: Sequence[Estimate]) -> dict[str, np.ndarray]:
    """(estimate - truth) / sigma of each parameter that both sides name and that has an error, (N,) by name.

    truth: a number, or one for each zone, bin or edge. Where only one side tells these apart, nothing is compared.
    """
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

"""Surfaces, of many, that an excess of counts goes with."""

import numpy as np
from scipy import sparse

from physics.rendering import Rendering
from physics.shares_amiss import evidence_of_shares
from physics.told_apart import GEOMETRY, WHICH

# Deviance that the factor of a surface must explain to be looked at: noise alone makes that of one in 2000.
EVIDENCE = 12.0


def surfaces_amiss(
    excess: np.ndarray, expected: np.ndarray, rendering: Rendering, first: int, most: int
) -> list[dict[str, float]]:
    """Surfaces beyond the `first` largest whose factors explain most of an excess, at most so many, the best first.

    excess, expected: (F, P, T) counts. Each beside a gain of every frame.
    """
    last = min(int(WHICH[0].high), int(rendering.light.surfaces.max(initial=0)))
    if last <= first:
        return []
    shares = _received(rendering, last)[..., first:]
    evidence = evidence_of_shares(excess, expected, rendering.background, shares, gained=(1,))
    best = [k for k in np.argsort(-evidence, kind="stable")[:most] if evidence[k] > EVIDENCE]
    return [{"surface": float(first + 1 + k), "told_by": GEOMETRY} for k in best]


def _received(rendering: Rendering, last: int) -> np.ndarray:
    """(F, P, last) what each zone receives of each surface."""
    light, weights = rendering.light, rendering.footprints.weights
    strength, number = np.nan_to_num(light.returns[0].strength), light.surfaces
    pixels, found = number[0].size, []
    for i, (sent, which) in enumerate(zip(strength, number, strict=True)):
        of = sparse.csr_matrix((sent.ravel(), (which.ravel(), np.arange(pixels))), (number.max() + 1, pixels))
        seen = weights[i] if weights.ndim == 4 else weights
        found.append((of @ seen.reshape(len(seen), pixels).T)[1 : last + 1].T)
    return np.array(found)

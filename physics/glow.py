"""How bright zones see the scene by light that no laser sent, which falls on all of it alike."""

import numpy as np

from physics.footprint import Footprints
from physics.light import Light


def glow(light: Light, footprints: Footprints) -> np.ndarray:
    """(F, P) Σ_u w_p(u) · ρ(u) over the mean of Σ_u w_p(u): 1 for the mean zone where all is white.

    A matt surface under even light is as bright however far it is and however it is tilted (Lambert's law). Nothing is
    seen where no surface is known. What was worked out for a scene is kept with it; it is to be read only.
    """
    made_of = light.range_m, light.assumed_reflectance, footprints
    kept = light.kept.get(glow.__qualname__)
    if kept is not None and all(mine is its for mine, its in zip(made_of, kept[0], strict=True)):
        return kept[1]
    seen = footprints.seen
    found = np.empty((light.frames, seen[0][1].shape[1]))
    for frame in range(light.frames):
        pixels, weights = seen[frame % len(seen)]
        reflectance = light.assumed_reflectance[frame].ravel()[pixels]
        known = (light.range_m[frame].ravel()[pixels] > 0) & np.isfinite(reflectance)
        white = np.where(known, reflectance, 0)
        found[frame] = white @ weights / max(float(weights.sum(axis=0, dtype=float).mean()), 1e-300)
    light.kept[glow.__qualname__] = made_of, found
    return found

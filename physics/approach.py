"""How far a camera has moved ahead, by what it sees, where nobody says how it moved."""

from functools import lru_cache
from itertools import pairwise

import numpy as np

from physics.light import Light
from physics.normals import vector_areas

# Surfaces that a camera passes along tell nothing of it: what is nearer by less than this part of the way is left out.
ALONG = 0.05


@lru_cache(maxsize=4)
def approached_m(light: Light) -> np.ndarray:
    """(F,) metres since the session's first frame; to read only.

    A plane n·X = d is in a pixel along a ray u of unit depth nearer by t·n_z/(n·u) when the camera has moved by t. From
    one frame to the next t is the median, weighted by that, over pixels seen in both: that of a scene which stands
    still, but for what moves in less than half of the view. Frames that are some of a session's keep what the whole
    session says.
    """
    if light.part_of is not None:
        every, frames = light.part_of
        return approached_m(every)[frames]
    depth = np.where(np.isfinite(light.range_m), light.range_m, 0) / np.linalg.norm(light.rays, axis=-1)
    steps = [0.0]
    for i, (before, after) in enumerate(pairwise(depth)):
        area = vector_areas(light, i)
        with np.errstate(invalid="ignore", divide="ignore"):
            nearer = area[..., 2] / (area * light.rays).sum(axis=-1)
            there = (before > 0) & (after > 0) & (nearer > ALONG)
        ways = (before - after)[there] / nearer[there]
        middle = {"weights": nearer[there], "method": "inverted_cdf"}
        steps.append(float(np.quantile(ways, 0.5, **middle)) if len(ways) else 0.0)
    return np.cumsum(steps)

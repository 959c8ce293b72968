"""How far the camera has come since the session began."""

from itertools import pairwise

import numpy as np

from physics.single_photons.facing import facets
from physics.single_photons.world import World

# What comes nearer by less than this part of the camera's way is not asked.
ALONG = 0.05


def ahead_m(world: World) -> float:
    """Metres, by the camera's poses, or else by how much nearer what it sees has come from image to image."""
    if world.start_from_camera is not None:
        return float(world.start_from_camera[2, 3])
    return sum(
        _step(before, after) for before, after in pairwise(world.at(t) for t in world.times_s if t <= world.time_s)
    )


def _step(before: World, after: World) -> float:
    """The way that leaves half of the surfaces, each by how much it faces the camera, behind where they should be.

    A square metre of a wall whose depth along a ray grows by n·u has its depth shortened by n_z for each metre.
    """
    normal, ray = facets(before), rays(before)
    with np.errstate(invalid="ignore", divide="ignore"):
        faces = normal[..., 2] / np.einsum("hwi,hwi->hw", normal, ray)
        way = (before.depth_m - after.depth_m) / faces
    told = np.isfinite(way) & (faces > ALONG) & (before.depth_m > 0) & (after.depth_m > 0)
    ways, weights = way[told], faces[told]
    if not len(ways):
        return 0.0
    ways, weights = ways[np.argsort(ways)], weights[np.argsort(ways)]
    return float(ways[np.flatnonzero(weights.cumsum() >= weights.sum() / 2)[0]])


def rays(world: World) -> np.ndarray:
    """(H, W, 3) rays of unit depth."""
    return world.points / world.depth_m[..., None]

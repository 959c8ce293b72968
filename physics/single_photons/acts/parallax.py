"""`parallax`: photons return to the LiDAR, which is beside the camera."""

from dataclasses import replace
from functools import partial

import numpy as np
from scipy.interpolate import RegularGridInterpolator
from scipy.ndimage import convolve1d
from scipy.special import ive

from physics.effect import Values
from physics.single_photons.looking import looking, looking_so
from physics.single_photons.sight import pixel_places, responses_at
from physics.single_photons.world import World
from recordings.refusal import Refusal

# Pixels beyond which nothing of a seam is smeared.
FARTHEST = 60


def world(world: World, values: Values, rng: np.random.Generator) -> World:
    """Zones that look from beside the camera at whatever geometry the world comes to have."""
    lidar, how = np.array([values["x"], values["y"], 0.0]), looking(world)
    how = replace(how, by_pixels=max(how.by_pixels, values["by_pixels"]))
    sees = partial(beside, lidar_m=lidar, whole=values["whole"])
    seen = looking_so(world, replace(how, ways=(*how.ways, lambda there: (1 - values["emitter"]) * sees(there))))
    if values["emitter"]:
        seen = replace(seen, gloss=seen.gloss * (1 + values["emitter"] * (_lit(world, sees(world)) - 1)))
    return _from_there(seen, values["ranges"] * lidar) if values["ranges"] and world.behind is None else seen


def _from_there(world: World, lidar_m: np.ndarray) -> World:
    """Photons whose way, and how many come by it, is from the LiDAR: each pixel's point stands so much behind."""
    ranges, theirs = world.range_m, np.linalg.norm(world.points - lidar_m, axis=-1)
    behind = np.where(np.isfinite(theirs), theirs - ranges, 0.0)
    gloss = world.gloss * np.where(theirs > 0, ranges**2 / np.where(theirs > 0, theirs, 1) ** 2, 1.0)
    return replace(world, gloss=gloss, behind=(np.ones(behind.shape), behind))


def beside(world: World, lidar_m: np.ndarray, whole: float = 0.0) -> np.ndarray:
    """(2, H, W) from each pixel to where in the full-size image the zones' maps are of use for it.

    Its point is seen from the LiDAR, and the ray followed to where the scan met it: there its zone was measured. The
    scan's patch was in the plane at the depth that the maps state; where they state none it was so far away that a
    ray's direction is all there is to it. The camera saw it at the place whose weights count. By the part `whole` all
    go as far as they do on average, each counted as often as zones see it.
    """
    points = world.points
    known = np.isfinite(points).all(axis=-1) & (points[..., 2] > 0)
    points = np.where(known[..., None], points, 1.0)
    ray = points - lidar_m
    depth = calibration_depth(world)
    met = ray if np.isinf(depth) else lidar_m + ray * (depth / ray[..., 2:])
    column, row, far = np.moveaxis(met @ world.intrinsics.T, -1, 0)
    width, height = world.maps.image_size
    rows, columns = world.depth_m.shape
    place = np.stack([(column / far + 0.5) * width / columns - 0.5, (row / far + 0.5) * height / rows - 0.5])
    away = np.where(known, place - np.stack(pixel_places(world.maps, (rows, columns))), 0.0)
    if not whole:
        return away
    together = [np.average(of, weights=known * world.weights.sum(axis=0)) for of in away]
    return away + whole * (np.reshape(together, (2, 1, 1)) - away)


def _lit(world: World, away: np.ndarray) -> np.ndarray:
    """(H, W) how many more photons the emitter sends to each pixel's point than when the zones were scanned.

    They came from as many directions as all zones saw them by, seams between which are none of the emitter's; away:
    (2, H, W) pixels of the full-size image, right and down, by which the place that counts is displaced.
    """
    maps, (rows, columns) = world.maps, world.depth_m.shape
    seen = responses_at(looking(world).taken, *pixel_places(maps, (rows, columns)))
    row, column = np.indices((rows, columns))
    lit = [zone for zone in seen if zone.any()]
    spread = [
        sum(np.cov(np.stack([row, column]).reshape(2, -1), ddof=0, aweights=zone.ravel()).diagonal()) for zone in lit
    ]
    variance = np.average(spread, weights=[zone.sum() for zone in lit]) / 2
    # The Gaussian of a grid (Lindeberg 1990): a photon's steps to either side come by chance, as many in the mean.
    kernel = ive(np.abs(np.arange(-FARTHEST, FARTHEST + 1)), variance / 4)
    profile = convolve1d(convolve1d(seen.sum(axis=0), kernel, axis=0), kernel, axis=1)
    profile = np.clip(profile, 0.03 * profile.max(), None)
    reads = RegularGridInterpolator((np.arange(rows), np.arange(columns)), profile)
    width, height = maps.image_size
    there = row + away[1] * rows / height, column + away[0] * columns / width
    return reads(np.stack([there[0].clip(0, rows - 1), there[1].clip(0, columns - 1)], axis=-1)) / profile


def calibration_depth(world: World) -> float:
    """Depth in metres of the plane in which the maps were taken, infinity where they do not say."""
    depth = world.maps.meta.get("calibration_range_m")
    if depth is None:
        return np.inf
    if isinstance(depth, bool) or not isinstance(depth, int | float) or not depth > 0:
        raise Refusal(f"response maps: calibration_range_m is {depth!r}, expected metres above 0")
    return float(depth)

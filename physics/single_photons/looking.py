"""Where zones look after acts have displaced or redrawn their maps."""

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from functools import lru_cache

import numpy as np
from scipy.interpolate import RegularGridInterpolator
from scipy.spatial import ConvexHull, Delaunay, cKDTree

from physics.single_photons.sight import pixel_places, responses_at, unit_response
from physics.single_photons.world import World
from recordings.maps import ResponseMaps

# The rim of the scan is walked in steps of so many pixels.
STEP_PX = 0.1
# A table is made by so many rows at a time.
ROWS = 64


@dataclass(frozen=True, eq=False)
class Looking(ResponseMaps):
    """Response maps that are not read where a pixel is, or not as they were taken.

    taken: the maps as they were taken. ways: functions of a world that say by how much farther right and down than
    each pixel its weights are read, (2, H, W) pixels of the full-size image, (2, P, H, W) where zones differ, or what
    broadcasts to either; they add up.
    redrawn: (P, Y, X) counts at the places of `table`, what they have become; None where they are as taken.
    by_pixels: part of what all zones alike are moved by which is read between pixels of the nominal grid.
    """

    taken: ResponseMaps | None = None
    ways: tuple[Callable[[World], np.ndarray], ...] = ()
    redrawn: np.ndarray | None = None
    by_pixels: float = 0.0


def looking(world: World) -> Looking:
    """How the zones of a world look at it."""
    maps = world.maps
    if isinstance(maps, Looking):
        return maps
    return Looking(**{field.name: getattr(maps, field.name) for field in fields(maps)}, taken=maps)


def looking_so(world: World, how: Looking) -> World:
    """The world with zones that look that way.

    Within the hull of the scan weights are those of the place where they are read. A map ends at the hull, which is no
    property of its zone: beyond, it is continued (`continued`). Pixels that the scan did not reach are dark in the
    nominal model, and what the continuation says of them at home is missing from them near home: it comes back as they
    move away by the reach, as 1 - d²/reach².
    """
    maps, shape = how.taken, world.depth_m.shape
    home = np.stack(pixel_places(maps, shape))
    ways = [way(world) for way in how.ways]
    if any(way.ndim == 4 for way in ways):
        alike = [way if way.ndim == 4 else way[:, None] for way in ways]
        each = np.broadcast_to(sum(alike), (2, world.zones, *shape))
        alone = [replace(how, ways=(lambda _, away=away: away,)) for away in np.moveaxis(each, 1, 0)]
        weights = np.stack([looking_so(world, one).weights[zone] for zone, one in enumerate(alone)])
        return replace(world, maps=how, weights=weights)
    away = sum(ways, np.zeros_like(home))
    counts = responses_at(maps, *home)
    moves = (away != 0).any(axis=0)
    if moves.any():
        missing = continued(maps, *home[:, moves]) - counts[:, moves]
        near = np.clip(1 - (away[:, moves] ** 2).sum(axis=0) / reach_px(maps) ** 2, 0, None)
        counts[:, moves] = np.clip(continued(maps, *(home + away)[:, moves]) - near * missing, 0, None)
    if how.by_pixels:
        # A pixel is as wide as it is, so that the last ones lead to nothing outside.
        rows, columns = (np.arange(-1, size + 1.0) for size in shape)
        at_home = np.pad(responses_at(maps, *home), ((0, 0), (1, 1), (1, 1)))
        reads = RegularGridInterpolator((rows, columns), np.moveaxis(at_home, 0, -1), "linear", False, 0.0)
        size = np.reshape(maps.image_size, (2, 1, 1)) / np.reshape(shape[::-1], (2, 1, 1))
        between = np.moveaxis(reads(np.moveaxis(((home + away + 0.5) / size - 0.5)[::-1], 0, -1)), -1, 0)
        counts = counts + how.by_pixels * (between - counts)
    if how.redrawn is not None:
        x, y, before = table(maps)
        reads = RegularGridInterpolator((y, x), np.moveaxis(how.redrawn - before, 0, -1), "linear", False, 0.0)
        counts = np.clip(counts + np.moveaxis(reads(np.moveaxis((home + away)[::-1], 0, -1)), -1, 0), 0, None)
    return replace(world, maps=how, weights=counts / unit_response(maps, shape))


def reach_px(maps: ResponseMaps) -> float:
    """How far beyond the hull a map goes on: 0.03 sides of the square that each position has to itself."""
    return 0.03 * float(np.sqrt(ConvexHull(_positions(maps)).volume / len(maps.xs)))


def continued(maps: ResponseMaps, x_px: np.ndarray, y_px: np.ndarray) -> np.ndarray:
    """(P, N) counts at N places; outside the hull, of its nearest place, less by d/reach at distance d from it."""
    counts = responses_at(maps, x_px, y_px)
    rim, there, reach = _rim(maps)
    outside = np.flatnonzero(Delaunay(_positions(maps)).find_simplex(np.column_stack([x_px, y_px])) < 0)
    distance, nearest = rim.query(np.column_stack([x_px, y_px])[outside])
    counts[:, outside] = there[:, nearest] * np.clip(1 - distance / reach, 0, None)
    return counts


@lru_cache(maxsize=2)
def table(maps: ResponseMaps) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """x (X,), y (Y,) and (P, Y, X) float32 continued counts: whole pixels of the image and of the scan.

    A scan counts no farther than an image's size beyond any side.
    """
    x, y = (
        np.arange(
            np.clip(np.floor(at.min()), -size, 0),
            np.clip(np.ceil(at.max()), size - 1, 2 * size - 1) + 1,
        )
        for at, size in zip((maps.xs, maps.ys), maps.image_size, strict=True)
    )
    counts = np.empty((len(maps.by_zone), len(y), len(x)), np.float32)
    for first in range(0, len(y), ROWS):
        places = np.meshgrid(x, y[first : first + ROWS])
        rows = continued(maps, *(at.ravel() for at in places))
        counts[:, first : first + ROWS] = rows.reshape(-1, *places[0].shape)
    return x, y, counts


@lru_cache(maxsize=2)
def _rim(maps: ResponseMaps) -> tuple[cKDTree, np.ndarray, float]:
    """Places along the hull of the scan, counts (P, N) at them, and the reach."""
    positions, responses = _positions(maps), maps.by_zone
    places, counts = [], []
    for a, b in Delaunay(positions).convex_hull:
        steps = int(np.ceil(np.linalg.norm(positions[b] - positions[a]) / STEP_PX)) + 1
        part = np.linspace(0, 1, steps)
        places.append(positions[a] + part[:, None] * (positions[b] - positions[a]))
        counts.append(responses[:, [a]] * (1 - part) + responses[:, [b]] * part)
    return cKDTree(np.concatenate(places)), np.concatenate(counts, axis=1), reach_px(maps)


def _positions(maps: ResponseMaps) -> np.ndarray:
    """(K, 2) x and y of the scan."""
    return np.column_stack([maps.xs, maps.ys]).astype(float)

"""Ways in which maps may be wrong: displaced, in another order, turned over; what follows, and how to undo it."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from fusion.predictions import Bench
from recordings.maps import ResponseMaps

REACH_PX, STEP_PX = 24.0, 6.0
# Ways to turn an image or a grid over: x mirrored, y mirrored, after rows have been taken for columns.
FLIPS = {
    "left-right": (True, False, False),
    "up-down": (False, True, False),
    "left-right and up-down": (True, True, False),
    "rows for columns": (False, False, True),
    "rows for columns and left-right": (True, False, True),
    "rows for columns and up-down": (False, True, True),
    "rows for columns, left-right and up-down": (True, True, True),
}

# Other optics, or a sensor mounted askew: angle in degrees, clockwise in the image, and size.
TURN_DEGREES, GROWTH = 7.0, 1.12
TWISTS = {
    "turned clockwise": (TURN_DEGREES, 1.0),
    "turned counter-clockwise": (-TURN_DEGREES, 1.0),
    "larger": (0.0, GROWTH),
    "smaller": (0.0, 1 / GROWTH),
}


def shifts_px() -> np.ndarray:
    """(S,) displacements along one axis that are tried, pixels of the full-size image."""
    return np.arange(-REACH_PX, REACH_PX + STEP_PX / 2, STEP_PX)


def shifted(scene: Bench) -> np.ndarray:
    """(S, S, F, P, T) signal with all footprints displaced by y (first axis) and x (second)."""
    tried = shifts_px()
    return np.array([[scene.signal(scene.where.moved(x, y)) for x in tried] for y in tried])


def exchanged(scene: Bench) -> np.ndarray:
    """(P, P, F, T) signal of zone p (first axis) if it looked where the maps say zone q does (second axis).

    What is the zone's own in time stays with it.
    """
    zones = np.arange(scene.sensor.zones)
    table = np.empty((len(zones), len(zones), scene.counts.shape[0], scene.counts.shape[2]))
    for k in zones:
        looks = (zones + k) % len(zones)
        table[zones, looks] = scene.signal(scene.where.changed(_taking(looks))).swapaxes(0, 1)
    return table


def _taking(looks: np.ndarray):
    """A change of footprints: each zone takes the weights of another."""
    return lambda weights: np.take(weights, looks, axis=-3)


def mirrored(scene: Bench) -> Iterator[tuple[str, np.ndarray]]:
    """Name, and (F, P, T) signal with the image of the maps turned over, zones keeping their names."""
    where = scene.where
    width, height = where.field.full_size
    for name, (across, down, swapped) in FLIPS.items():
        x, y = where.x_px, where.y_px
        if swapped:
            x, y = y * width / height, x * height / width
        x, y = width - 1 - x if across else x, height - 1 - y if down else y
        yield name, scene.signal(where.read_at(x, y))


def twisted(scene: Bench) -> Iterator[tuple[str, np.ndarray]]:
    """Name, and (F, P, T) signal with all footprints turned about their middle, or larger or smaller."""
    where = scene.where
    weights = where.weights.sum(axis=-3)
    middle = [(weights * at).sum() / max(weights.sum(), 1e-300) for at in (where.x_px, where.y_px)]
    x, y = where.x_px - middle[0], where.y_px - middle[1]
    for name, (angle, size) in TWISTS.items():
        cosine, sine = np.cos(np.radians(angle)) / size, np.sin(np.radians(angle)) / size
        # What is turned by an angle is read at places turned back.
        there = cosine * x + sine * y, cosine * y - sine * x
        yield name, scene.signal(where.moved(x - there[0], y - there[1]))


def mirrored_order(grid: tuple[int, int]) -> dict[str, np.ndarray]:
    """Name -> (P,) which map each zone takes when the order of zones is turned over; swapped rows need a square."""
    zones, found = np.arange(grid[0] * grid[1]).reshape(grid), {}
    for name, (across, down, swapped) in FLIPS.items():
        if swapped and grid[0] != grid[1]:
            continue
        order = zones.T if swapped else zones
        order = order[:, ::-1] if across else order
        order = order[::-1] if down else order
        if (order != zones).any():
            found[name] = order.ravel()
    return found


def displaced(maps: ResponseMaps, shift_px: np.ndarray) -> ResponseMaps:
    """The maps with all footprints displaced by (2,) x, y."""
    return replace(maps, xs=maps.xs + shift_px[0], ys=maps.ys + shift_px[1])


def reordered(maps: ResponseMaps, order: np.ndarray) -> ResponseMaps:
    """The maps with zone p looking where zone order[p] did."""
    taken = {
        name: getattr(maps, name).reshape(len(order), -1)[order].reshape(maps.responses.shape)
        for name in ("responses", "sigma", "flags")
        if getattr(maps, name) is not None
    }
    return replace(maps, **taken)


def turned(maps: ResponseMaps, name: str) -> ResponseMaps:
    """The maps with their image turned over, as `mirrored` sees it: the inverse of what it does to pixels."""
    across, down, swapped = FLIPS[name]
    width, height = maps.image_size
    x = width - 1 - maps.xs if across else maps.xs
    y = height - 1 - maps.ys if down else maps.ys
    if swapped:
        x, y = y * width / height, x * height / width
    return replace(maps, xs=x, ys=y)

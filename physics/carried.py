"""What the camera sees between its frames where the scene stands still and it is known how the camera moved."""

from dataclasses import replace

import numpy as np
from numba import njit

from physics.light import Light, Return
from physics.workers import in_parallel

# Surfaces are seen where rays to them meet: guesses of how far away that is are bettered so many times.
BETTERED = 3
# What is not known is taken to be so far away that it turns with the camera alone. Nothing comes nearer than this.
FAR_M, LEAST_M = 1e3, 1e-3
# Neighbours whose ranges differ by less than this part of themselves are of one surface.
ONE_SURFACE = 0.02


def carried(light: Light, lower: np.ndarray, upper: np.ndarray, part: np.ndarray, time_s: np.ndarray) -> Light:
    """Light at times (F,), seconds, of frames `lower` and `upper` (F,) as they are seen from where the camera is then.

    part: (F,) how much of the second there is, 0 to 1. A pixel sees the four pixels of either frame around the point
    that it looks at, each by its share of the way between their centres: of one surface their mean, otherwise a return
    each. Strength goes with 1/r²; by how much surfaces turn towards the sensor is left as it was. What no frame saw is
    missing. Range, reflectance and cosine, by which other effects go, are those of the nearer frame's nearest pixel.
    """
    moved = light.motion.at(time_s)
    there = [np.linalg.inv(moved) @ light.motion.at(light.time_s[of]) for of in (lower, upper)]
    back = [np.linalg.inv(one) for one in there]
    shape, ways = light.range_m.shape, len(light.returns)
    found = np.ones((ways, 2, 4, 2, *shape), np.float32)  # [way, frame, neighbour, range and strength, ...]
    found[:, :, :, 1] = 0
    nearest = np.empty((2, *shape), np.int32)
    weights = np.clip(np.stack([1 - part, part]), 0, 1)

    def one(i: int) -> None:
        for side, of in enumerate((lower, upper)):
            if weights[side, i] == 0 and weights[1 - side, i] != 0:
                nearest[side, i] = -1
                continue
            at = of[i]
            where, left = _sources(light.range_m[at], light.rays, light.intrinsics, there[side][i], back[side][i])
            nearest[side, i] = where[..., 0]
            for way, sent in enumerate(light.returns):
                _gather(
                    light.range_m[at], sent.range_m[at], sent.strength[at] * np.float32(weights[side, i]),
                    light.rays, there[side][i], where, left, found[way, side, :, :, i],
                )  # fmt: skip

    in_parallel(one, range(len(time_s)))
    returns = [Return(*pair) for pair in found.reshape(-1, 2, *shape) if pair[1].any()]
    side = np.where(weights[1] > weights[0], 1, 0)
    frame, pixel = np.where(side == 1, upper, lower), nearest[side, np.arange(len(side))].reshape(shape[0], -1)

    def picked(values: np.ndarray) -> np.ndarray:
        return np.take_along_axis(values[frame].reshape(shape[0], -1), pixel, axis=1).reshape(shape)

    here = found[0, side, 0, :, np.arange(len(side))]
    ranges = np.where(here[:, 1] > 0, here[:, 0], picked(light.range_m))
    albedo, cosine = picked(light.reflectance), picked(light.cosine)
    missing = np.count_nonzero(~(ranges > 0) | np.isnan(albedo) | np.isnan(cosine), axis=(1, 2))
    empty = Return(np.ones(shape, np.float32), np.zeros(shape, np.float32))
    return replace(
        light, range_m=ranges, reflectance=albedo, cosine=cosine, returns=tuple(returns) or (empty,), missing=missing
    )


def both(one: Light, other: Light, part: float) -> Light:
    """Light of which the part `part` is other light; what effects go by is that of most of it."""
    returns = [Return(way.range_m, way.strength * np.float32(1 - part)) for way in one.returns]
    returns += [Return(way.range_m, way.strength * np.float32(part)) for way in other.returns]
    return replace(other if part > 0.5 else one, returns=tuple(returns))


@njit(nogil=True, cache=True)
def _moved(there, x, y, z):
    """A point (3,) as another camera sees it."""
    return (
        there[0, 0] * x + there[0, 1] * y + there[0, 2] * z + there[0, 3],
        there[1, 0] * x + there[1, 1] * y + there[1, 2] * z + there[1, 3],
        there[2, 0] * x + there[2, 1] * y + there[2, 2] * z + there[2, 3],
    )


@njit(nogil=True, cache=True)
def _sources(ranges, rays, intrinsics, there, back):
    """(H, W, 4) pixels of a frame around the point that each pixel of another camera sees, and (H, W, 4) shares.

    there: (4, 4) that camera from the frame's. back: the other way. The nearest comes first. Beyond the border is the
    border.
    """
    height, width = ranges.shape
    where = np.empty((height, width, 4), np.int32)
    left = np.empty((height, width, 4), np.float32)
    for v in range(height):
        for u in range(width):
            ray = rays[v, u]
            x, y, depth = float(u), float(v), FAR_M
            for _ in range(BETTERED):
                column = min(max(int(np.rint(x)), 0), width - 1)
                row = min(max(int(np.rint(y)), 0), height - 1)
                r = ranges[row, column]
                if r > 0:
                    one = rays[row, column]
                    z = r / np.sqrt(one[0] ** 2 + one[1] ** 2 + one[2] ** 2)
                    depth = max(_moved(there, z * one[0], z * one[1], z * one[2])[2], LEAST_M)
                at = _moved(back, depth * ray[0], depth * ray[1], depth * ray[2])
                if at[2] > 0:
                    x = intrinsics[0, 0] * at[0] / at[2] + intrinsics[0, 2]
                    y = intrinsics[1, 1] * at[1] / at[2] + intrinsics[1, 2]
            x, y = min(max(x, 0.0), width - 1.0), min(max(y, 0.0), height - 1.0)
            column, row = min(int(x), max(width - 2, 0)), min(int(y), max(height - 2, 0))
            across, down = x - column, y - row
            best = 0
            for k in range(4):
                right, below = k % 2, k // 2
                share = (across if right else 1 - across) * (down if below else 1 - down)
                where[v, u, k] = min(row + below, height - 1) * width + min(column + right, width - 1)
                left[v, u, k] = share
                best = k if share > left[v, u, best] else best
            where[v, u, 0], where[v, u, best] = where[v, u, best], where[v, u, 0]
            left[v, u, 0], left[v, u, best] = left[v, u, best], left[v, u, 0]
    return where, left


@njit(nogil=True, cache=True)
def _gather(direct, ranges, sent, rays, there, where, left, out):
    """Fill (4, 2, H, W) `out` with range and strength that each pixel sees of four pixels of a frame.

    direct: (H, W) range of the surface each pixel sees. ranges, sent: (H, W) of a way of light.
    """
    height, width = direct.shape
    seen, changed = np.empty(4), np.empty(4)
    for v in range(height):
        for u in range(width):
            near, far, total, mean = np.inf, 0.0, 0.0, 0.0
            for k in range(4):
                row, column = where[v, u, k] // width, where[v, u, k] % width
                r, s = direct[row, column], sent[row, column] * left[v, u, k]
                seen[k], changed[k] = 1.0, 0.0
                if not (r > 0 and s > 0):
                    continue
                one = rays[row, column]
                z = r / np.sqrt(one[0] ** 2 + one[1] ** 2 + one[2] ** 2)
                point = _moved(there, z * one[0], z * one[1], z * one[2])
                then = max(np.sqrt(point[0] ** 2 + point[1] ** 2 + point[2] ** 2), LEAST_M)
                seen[k], changed[k] = max(ranges[row, column] + then - r, LEAST_M), s * (r / then) ** 2
                near, far = min(near, seen[k]), max(far, seen[k])
                total, mean = total + changed[k], mean + seen[k] * changed[k]
            if total > 0 and far <= near * (1 + ONE_SURFACE):
                out[0, 0, v, u], out[0, 1, v, u] = mean / total, total
            else:
                for k in range(4):
                    out[k, 0, v, u], out[k, 1, v, u] = seen[k], changed[k]

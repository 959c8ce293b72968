"""What a camera that has moved sees of the pixels of an image: which, how much of each, and how far away."""

import numpy as np
from numba import njit

# Surfaces are seen where rays to them meet: guesses of how far away that is are bettered so many times.
BETTERED = 3
# Nothing comes nearer than this.
LEAST_M = 1e-3
# Neighbours whose ranges differ by less than this part of themselves are of one surface.
ONE_SURFACE = 0.02


@njit(nogil=True, cache=True)
def moved(there, x, y, z):
    """A point (3,) as another camera sees it."""
    return (
        there[0, 0] * x + there[0, 1] * y + there[0, 2] * z + there[0, 3],
        there[1, 0] * x + there[1, 1] * y + there[1, 2] * z + there[1, 3],
        there[2, 0] * x + there[2, 1] * y + there[2, 2] * z + there[2, 3],
    )


@njit(nogil=True, cache=True)
def pixel(intrinsics, x, y, z):
    """Column and row, as fractions of pixels too, where a camera sees a point ahead of it."""
    column = (intrinsics[0, 0] * x + intrinsics[0, 1] * y) / z + intrinsics[0, 2]
    return column, intrinsics[1, 1] * y / z + intrinsics[1, 2]


@njit(nogil=True, cache=True)
def from_there(ranges, rays, there):
    """(2, H, W) how far what each pixel of a frame sees is from another camera, and how far ahead of it; else 0.

    ranges: (H, W) metres, 0 where nothing is seen. there: (4, 4) that camera from the frame's.
    """
    height, width = ranges.shape
    out = np.zeros((2, height, width))
    for v in range(height):
        for u in range(width):
            r, one = ranges[v, u], rays[v, u]
            if r > 0:
                z = r / np.sqrt(one[0] ** 2 + one[1] ** 2 + one[2] ** 2)
                x, y, z = moved(there, z * one[0], z * one[1], z * one[2])
                out[0, v, u], out[1, v, u] = np.sqrt(x * x + y * y + z * z), z
    return out


@njit(nogil=True, cache=True)
def looking(ranges, then, rays, intrinsics, there):
    """(4,) pixels of another camera that may look at what each pixel of a frame sees, as a box for `sources`.

    ranges: (H, W) metres, 0 where nothing is seen. then: (H, W) as `from_there` gives it. there: (4, 4) that camera
    from the frame's. A pixel sees four of a frame's: it looks at most one of those, as large as it is by then, aside;
    what is at the border of a frame goes on to the border.
    """
    height, width = ranges.shape
    top, bottom, first, last = np.inf, -np.inf, np.inf, -np.inf
    for v in range(height):
        for u in range(width):
            r, one = ranges[v, u], rays[v, u]
            if r > 0:
                z = r / np.sqrt(one[0] ** 2 + one[1] ** 2 + one[2] ** 2)
                at = moved(there, z * one[0], z * one[1], z * one[2])
                if at[2] < LEAST_M:
                    return np.array([0, height, 0, width])
                column, row = pixel(intrinsics, at[0], at[1], at[2])
                aside = 1 + r / max(then[v, u], LEAST_M)
                top, bottom = min(top, row - aside), max(bottom, row + aside)
                first, last = min(first, column - aside), max(last, column + aside)
                top, bottom = 0.0 if v == 0 else top, np.inf if v == height - 1 else bottom
                first, last = 0.0 if u == 0 else first, np.inf if u == width - 1 else last
    top, bottom = min(max(top, 0.0), height), min(max(bottom + 1, 0.0), height)
    first, last = min(max(first, 0.0), width), min(max(last + 1, 0.0), width)
    if bottom <= top or last <= first:
        return np.zeros(4, np.int64)
    return np.array([int(top), int(np.ceil(bottom)), int(first), int(np.ceil(last))])


@njit(nogil=True, cache=True)
def filled(then, where, left):
    """(2, h, w) how much of each pixel is filled by what four pixels of a frame see, and its range in that sum.

    then: (H, W) as `from_there` gives it. where, left: (h, w, 4) as `sources` gives them.
    """
    width = then.shape[1]
    out = np.zeros((2, *where.shape[:2]), np.float32)
    for v in range(where.shape[0]):
        for u in range(where.shape[1]):
            for k in range(4):
                far = then[where[v, u, k] // width, where[v, u, k] % width]
                if far > 0:
                    out[0, v, u] += left[v, u, k]
                    out[1, v, u] += left[v, u, k] * far
    return out


@njit(nogil=True, cache=True)
def sources(ahead, rays, intrinsics, back, guess, box):
    """(h, w, 4) pixels of a frame around the point that each pixel of another camera sees, and (h, w, 4) shares.

    ahead: (H, W) as `from_there` gives it. back: (4, 4) the frame's camera from the other. guess: metres, how far away
    it may be. box: first row, row after the last, first column, column after the last of the pixels that look. The
    nearest comes first. Beyond the border is the border.
    """
    height, width = ahead.shape
    where = np.empty((box[1] - box[0], box[3] - box[2], 4), np.int32)
    left = np.empty(where.shape, np.float32)
    for v in range(where.shape[0]):
        for u in range(where.shape[1]):
            ray = rays[box[0] + v, box[2] + u]
            x, y, depth, last = float(box[2] + u), float(box[0] + v), guess, -1
            for _ in range(BETTERED):
                column = min(max(int(np.rint(x)), 0), width - 1)
                row = min(max(int(np.rint(y)), 0), height - 1)
                if row * width + column == last:
                    break  # It would be the same again.
                last = row * width + column
                z = ahead[row, column]
                if z != 0:
                    depth = max(z, LEAST_M)
                at = moved(back, depth * ray[0], depth * ray[1], depth * ray[2])
                if at[2] > 0:
                    x, y = pixel(intrinsics, at[0], at[1], at[2])
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
def gather(direct, then, ranges, sent, where, left, out):
    """Fill (4, 2, h, w) `out` with range and strength that each pixel sees of four pixels of a frame.

    direct, then: (H, W) range of the surface each pixel sees, and as `from_there` gives it. ranges, sent: (H, W) of a
    way of light. where, left: (h, w, 4) as `sources` gives them.
    """
    width = direct.shape[1]
    seen, changed = np.empty(4), np.empty(4)
    for v in range(where.shape[0]):
        for u in range(where.shape[1]):
            near, far, total, mean = np.inf, 0.0, 0.0, 0.0
            for k in range(4):
                row, column = where[v, u, k] // width, where[v, u, k] % width
                r, s = direct[row, column], sent[row, column] * left[v, u, k]
                seen[k], changed[k] = 1.0, 0.0
                if not (r > 0 and s > 0):
                    continue
                now = max(then[row, column], LEAST_M)
                seen[k], changed[k] = max(ranges[row, column] + now - r, LEAST_M), s * (r / now) ** 2
                near, far = min(near, seen[k]), max(far, seen[k])
                total, mean = total + changed[k], mean + seen[k] * changed[k]
            if total > 0 and far <= near * (1 + ONE_SURFACE):
                out[0, 0, v, u], out[0, 1, v, u] = mean / total, total
            else:
                for k in range(4):
                    out[k, 0, v, u], out[k, 1, v, u] = seen[k], changed[k]


@njit(nogil=True, cache=True)
def put(ranges, strength, slot_ranges, slots):
    """Add light (H, W) to the first of some slots (N, H, W) that is empty in each pixel, or to the mean of the last."""
    last = slots.shape[0] - 1
    for v in range(ranges.shape[0]):
        for u in range(ranges.shape[1]):
            s = strength[v, u]
            if not s > 0:
                continue
            n = 0
            while n < last and slots[n, v, u] > 0:
                n += 1
            total = slots[n, v, u] + s
            slot_ranges[n, v, u] += (ranges[v, u] - slot_ranges[n, v, u]) * (s / total)
            slots[n, v, u] = total

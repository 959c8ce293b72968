"""Surfaces told apart by their geometry alone, and followed from frame to frame.

On a plane the inverse of depth is linear in the image (Faugeras 1993, Three-Dimensional Computer Vision, section 7):
its second differences vanish but for curvature, and are large where surfaces meet or hide each other.
"""

from functools import lru_cache

import numpy as np
from numba import njit
from scipy.ndimage import label

from physics.geometry import pixel_rays
from physics.trail import Trail

# Change of a surface's slope from pixel to pixel, as a tangent, that ends it; or so many times the median where depth
# is noisy.
BENT, NOISY = 0.2, 6.0
# Pieces of fewer pixels than this part of the image are no surfaces of their own.
SMALL = 0.004
# Relative difference of ranges within which pieces lie on one plane, and from which on one thing hides another.
COPLANAR, BEHIND = 0.01, 0.1
# Neighbours of a pixel: by how many rows and columns it is after them.
SIDES = ((0, 1), (0, -1), (1, 0), (-1, 0))


def segments(range_m: np.ndarray, intrinsics: np.ndarray, start_from_camera: np.ndarray | None = None) -> np.ndarray:
    """(F, H, W) int32 number of the surface at each pixel, from 1 in order of their pixels in all frames; 0 at none.

    range_m: (F, H, W) metres, NaN or 0 where unknown. intrinsics: (3, 3) pinhole matrix of the grid. start_from_camera:
    (F, 4, 4) where the camera was, None where nobody knows.
    """
    return _segments(_Ranges(range_m, np.asarray(intrinsics, float), start_from_camera))


class _Ranges:
    """Ranges of all frames: the same only as themselves, so that what was made of them is kept as long as needed."""

    def __init__(self, range_m: np.ndarray, intrinsics: np.ndarray, cameras: np.ndarray | None) -> None:
        self.range_m, self.intrinsics, self.cameras = range_m, intrinsics, cameras

    def __hash__(self) -> int:
        return id(self.range_m)

    def __eq__(self, other: object) -> bool:
        same = isinstance(other, _Ranges) and other.range_m is self.range_m
        return same and np.array_equal(np.asarray(self.cameras), np.asarray(other.cameras))


@lru_cache(maxsize=4)
def _segments(ranges: _Ranges) -> np.ndarray:
    """See `segments`."""
    rays = pixel_rays(ranges.intrinsics, ranges.range_m.shape[1:])
    length, focal_px = np.linalg.norm(rays, axis=-1), (ranges.intrinsics[0, 0], ranges.intrinsics[1, 1])
    trail = Trail(len(ranges.range_m), rays, ranges.intrinsics, ranges.cameras)
    for range_m in ranges.range_m:
        known = np.isfinite(range_m) & (range_m > 0)
        inverse = np.where(known, length / np.where(known, range_m, 1), np.nan)
        trail.add(_in_frame(inverse, rays, focal_px), inverse)
    sizes = np.bincount(trail.numbers.ravel(), minlength=trail.count + 1)
    sizes[0] = 0
    rank = np.zeros(trail.count + 1, np.int32)
    rank[np.argsort(-sizes, kind="stable")] = np.arange(1, trail.count + 2)
    rank[sizes == 0] = 0
    return rank[trail.numbers]


def _in_frame(inverse: np.ndarray, rays: np.ndarray, focal_px: tuple[float, float]) -> np.ndarray:
    """(H, W) numbers of surfaces in one frame, from inverse depth (H, W), NaN where unknown."""
    bends = []
    for axis, focal in ((1, focal_px[0]), (0, focal_px[1])):
        kink = np.zeros(inverse.shape)
        inner = tuple(slice(1, -1) if a == axis else slice(None) for a in (0, 1))
        kink[inner] = np.diff(inverse, 2, axis=axis)
        bends.append(np.abs(kink) * focal / inverse)
    known = np.isfinite(inverse)
    # Beside unknown depth a surface may go on.
    bend = np.nan_to_num(np.maximum(*bends))
    found, count = label(known & (bend < max(BENT, NOISY * float(np.median(bend)))))
    sizes = np.bincount(found.ravel(), minlength=count + 1)
    kept = np.flatnonzero(sizes[1:] >= SMALL * inverse.size) + 1
    found = _grown(_joined(np.where(np.isin(found, kept), found, 0), kept, inverse, rays), inverse)
    # What stands apart from every piece is a thing of its own, however it bends, if it is not too small for one.
    apart, count = label(known & (found == 0))
    large = np.flatnonzero(np.bincount(apart.ravel(), minlength=count + 1)[1:] >= SMALL * inverse.size) + 1
    number = np.zeros(count + 1, np.int32)
    number[large] = int(found.max()) + np.arange(1, len(large) + 1)
    return np.where(found > 0, found, number[apart])


def _grown(found: np.ndarray, inverse: np.ndarray) -> np.ndarray:
    """Pieces (H, W) with what bends: each pixel goes with the neighbour that lies on a plane with it, if one does."""
    framed, middle = np.pad(inverse, 2, constant_values=np.nan), (slice(2, -2), slice(2, -2))
    beside, beyond = (
        np.stack([np.roll(framed, (many * down, many * right), (0, 1))[middle] for down, right in SIDES])
        for many in (1, 2)
    )
    off = np.abs(inverse - np.where(np.isfinite(beyond), 2 * beside - beyond, beside))
    off = np.where(off < BEHIND * inverse, off, np.inf)
    while True:
        # A neighbour that is in no piece yet may be in one soon; where all wait for each other, the pieces decide.
        for patient in (True, False):
            grown = _joining(found, off, patient)
            if (grown != found).any():
                break
        else:
            return found
        found = grown


@njit(nogil=True, cache=True)
def _joining(found, off, patient):
    """Pieces (H, W) and pixels that join the neighbour which is least `off` (4, H, W), if it is in a piece.

    Only neighbours that are in one are asked where not patient.
    """
    height, width = found.shape
    grown = found.copy()
    for v in range(height):
        for u in range(width):
            if found[v, u] > 0:
                continue
            nearest = np.inf
            for side in range(4):
                y, x = v - SIDES[side][0], u - SIDES[side][1]
                number = found[y, x] if 0 <= y < height and 0 <= x < width else 0
                if off[side, v, u] < nearest and (patient or number > 0):
                    nearest, grown[v, u] = off[side, v, u], number
    return grown


def _joined(found: np.ndarray, numbers: np.ndarray, inverse: np.ndarray, rays: np.ndarray) -> np.ndarray:
    """Pieces (H, W) of one plane that something hides in the middle become one; numbered from 1."""
    plane: dict[int, np.ndarray] = {}
    new = np.zeros(int(found.max()) + 1, np.int32)
    for number in numbers:
        at = found == number
        points = rays[at]
        fitted = np.linalg.lstsq(points.T @ points, points.T @ inverse[at], rcond=None)[0]
        flat = np.abs(points @ fitted / inverse[at] - 1).max() < COPLANAR
        for other, theirs in plane.items():
            there = found == other
            off = max(
                np.abs(points @ theirs / inverse[at] - 1).max(), np.abs(rays[there] @ fitted / inverse[there] - 1).max()
            )
            if flat and off < COPLANAR:
                new[number] = new[other]
                break
        else:
            new[number] = new.max() + 1
            if flat:
                plane[number] = fitted
    return new[found]

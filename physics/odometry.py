"""How a camera moves through a scene, by the ranges it sees: of the scene, or of what is carried before it."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numba import njit

from physics.kept import kept_of_session
from physics.light import Light
from physics.motion import Motion
from physics.normals import vector_areas
from physics.seen_from import moved, pixel
from physics.workers import in_parallel

# Points that are farther from a surface than these parts of their range are not of it: to find it, then to fit it.
WITHIN = (0.15, 0.05, 0.02)
STEPS = 12
# So many points, spread evenly, tell as much as all.
POINTS = 600
# Where so much of the view stands still to this part of its range, nothing but things in it moves.
STILL, EXACT = 0.3, 1e-3
# What lays more points on surfaces by less than this is no better.
BETTER = 0.05
# Along what surfaces tell less of than this part of the most, nothing moves but as it was thought to.
LITTLE = 2e-3


def camera_motion(light: Light) -> Motion:
    """How the camera moved, as was recorded, or where nobody says as it seems."""
    return apparent_motion(light) if light.motion is None else light.motion


def moved_m(light: Light) -> np.ndarray:
    """(F, 3) metres by which the camera has moved to the right, down and ahead, as it looked at the start."""
    return camera_motion(light).moved_m(light.time_s)


@kept_of_session
def apparent_motion(light: Light) -> Motion:
    """The motion of a camera for which most of what is seen stands still; in all frames of the session.

    From each frame to the next the rigid motion that lays the points of one on the surfaces of the other: point to
    plane (Chen and Medioni 1992, Image and Vision Computing 10, 145), points and planes paired by where the points are
    seen (Blais and Levine 1995, IEEE PAMI 17, 820), with Tukey's biweight of the distance over the range. It begins at
    the motion that was recorded, or with none and with that of the step before, and straight ahead by what most comes
    nearer, and takes what lays more points on surfaces; where the first does so for many to a thousandth it is left at
    that. Of what it sees nothing of, a camera that slides along a wall, it keeps that beginning.
    """
    views = views_of(light)
    known = None if light.motion is None else light.motion.at(light.time_s)
    pairs = list(pairwise(range(len(views.depth))))
    steps = [np.eye(4) if known is None else np.linalg.solve(known[i], known[j]) for i, j in pairs]
    left = [views.left(i, j, step, EXACT) for (i, j), step in zip(pairs, steps, strict=True)]
    if not pairs or np.median(left) < 1 - STILL:
        still = np.tile(np.eye(4), (light.frames, 1, 1))
        return Motion(np.asarray(light.time_s, float), still if known is None else known)
    way, step = [np.eye(4) if known is None else known[0]], np.eye(4)
    for (i, j), thought in zip(pairs, steps, strict=True):
        starts = (thought, step, views.nearer(i, j)) if known is None else (thought, views.nearer(i, j))
        found = [views.aligned(i, j, start) for start in starts]
        step = next(motion for motion, loss in found if loss <= min(loss for _, loss in found) + BETTER)
        way.append(way[-1] @ step)
    return Motion(np.asarray(light.time_s, float), np.array(way))


@dataclass(frozen=True, eq=False)
class Views:
    """Surfaces as they are seen. depth: (F, H, W) metres along z, 0 where unknown. normals: (F, H, W, 3), NaN where
    unknown. rays: (H, W, 3) of length 1 along z. intrinsics: (3, 3).
    """

    depth: np.ndarray
    normals: np.ndarray
    rays: np.ndarray
    intrinsics: np.ndarray

    def middle(self, i: int, there: np.ndarray) -> np.ndarray:
        """(3,) metres: the middle of the points that some pixels (H, W) of a frame see."""
        there = there & (self.depth[i] > 0)
        return (self.rays[there] * self.depth[i][there][:, None]).mean(axis=0)

    def nearer(self, i: int, j: int) -> np.ndarray:
        """(4, 4) motion of frame j to frame i straight ahead, as far as the median of what is seen has come nearer."""
        out = np.eye(4)
        middles = [
            np.median(depth[depth > 0]) if (depth > 0).any() else 0.0 for depth in (self.depth[i], self.depth[j])
        ]
        out[2, 3] = middles[0] - middles[1]
        return out

    def aligned(self, i: int, j: int, start: np.ndarray, there: np.ndarray | None = None) -> tuple[np.ndarray, float]:
        """Motion (4, 4) of frame j to frame i, of all that is seen or of pixels (F, H, W); see `aligned`."""
        one, other = (self.depth[of] if there is None else self.depth[of] * there[of] for of in (i, j))
        thin = int(np.sqrt(np.count_nonzero(other) / POINTS))
        if thin > 1:
            few = np.zeros_like(other)
            few[::thin, ::thin] = other[::thin, ::thin]
            other = few
        return aligned(one, self.normals[i], other, self.rays, self.intrinsics, start)

    def left(self, i: int, j: int, motion: np.ndarray, within: float) -> float:
        """Mean loss over points of frame j, of those that such a motion does not lay on surfaces of frame i."""
        there = self.depth[i], self.normals[i], self.depth[j], self.rays, self.intrinsics
        return float(_equations(*there, motion, within)[2])


@kept_of_session
def views_of(light: Light) -> Views:
    """All frames of a session."""
    ranges = np.where(np.isfinite(light.range_m), light.range_m, 0).astype(float)
    areas = np.stack(in_parallel(lambda i: vector_areas(light, i), range(light.frames)))
    with np.errstate(invalid="ignore", divide="ignore"):
        normals = areas / np.linalg.norm(areas, axis=-1, keepdims=True)
    return Views(ranges / np.linalg.norm(light.rays, axis=-1), normals, light.rays, light.intrinsics)


@njit(nogil=True, cache=True)
def aligned(depth, normals, other, rays, intrinsics, start):
    """(4, 4) from the camera's frame of another image (H, W) to that of this one, and how much is not laid on surfaces.

    depth: (H, W) metres along z, 0 where unknown; normals: (H, W, 3), NaN where unknown. other: (H, W) its
    depth. start: (4, 4). The second is the mean loss over the other's points, 0 to 1.
    """
    here, loss = start.copy(), 1.0
    for within in WITHIN:
        for _ in range(STEPS):
            information, score, loss = _equations(depth, normals, other, rays, intrinsics, here, within)
            told, along = np.linalg.eigh(information)
            if not told[-1] > 0:
                return here, 1.0
            change = np.zeros(6)
            for k in range(6):
                if told[k] > LITTLE * told[-1]:
                    change -= along[:, k] * ((along[:, k] * score).sum() / told[k])
            here = _by_little(change) @ here
            if np.abs(change).max() < 1e-6:
                break
    return here, loss


@njit(nogil=True, cache=True)
def _by_little(change):
    """(4, 4) a turn by a rotation vector (Rodrigues 1840) and then a shift, (6,)."""
    x, y, z = change[:3]
    angle = np.sqrt(x * x + y * y + z * z)
    # sin(a) / a and (1 - cos(a)) / a², which rounding leaves nothing of near 0.
    first, second = np.sinc(angle / np.pi), np.sinc(angle / (2 * np.pi)) ** 2 / 2
    across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    step = np.eye(4)
    step[:3, :3] += first * across + second * (across @ across)
    step[:3, 3] = change[3:]
    return step


@njit(nogil=True, cache=True)
def _equations(depth, normals, other, rays, intrinsics, here, within):
    """(6, 6) information and (6,) score of a small turn and shift after `here`; mean of Tukey's loss, 1 at most."""
    height, width = depth.shape
    information, score = np.zeros((6, 6)), np.zeros(6)
    lost, points, slope = 0.0, 0, np.empty(6)
    for v in range(height):
        for u in range(width):
            z = other[v, u]
            if not z > 0:
                continue
            points += 1
            lost += 1.0
            px, py, pz = moved(here, z * rays[v, u, 0], z * rays[v, u, 1], z)
            if not pz > 0:
                continue
            column, row = pixel(intrinsics, px, py, pz)
            column, row = int(np.rint(column)), int(np.rint(row))
            if row < 0 or column < 0 or row >= height or column >= width:
                continue
            there, normal = depth[row, column], normals[row, column]
            if not (there > 0 and normal[0] == normal[0]):
                continue
            ray = rays[row, column]
            size = there * np.sqrt(ray[0] ** 2 + ray[1] ** 2 + ray[2] ** 2)
            dx, dy, dz = px - there * ray[0], py - there * ray[1], pz - there * ray[2]
            off = (normal[0] * dx + normal[1] * dy + normal[2] * dz) / size
            if abs(off) >= within / 2 or dx * dx + dy * dy + dz * dz > (2 * within * size) ** 2:
                continue
            kept = 1 - (2 * off / within) ** 2
            lost -= kept**3
            slope[0] = (py * normal[2] - pz * normal[1]) / size
            slope[1] = (pz * normal[0] - px * normal[2]) / size
            slope[2] = (px * normal[1] - py * normal[0]) / size
            slope[3], slope[4], slope[5] = normal[0] / size, normal[1] / size, normal[2] / size
            for a in range(6):
                score[a] += kept**2 * slope[a] * off
                for b in range(6):
                    information[a, b] += kept**2 * slope[a] * slope[b]
    return information, score, lost / max(points, 1)

"""What moves by itself in what a camera sees, each thing with the rigid motion it has."""

from dataclasses import dataclass
from itertools import pairwise, product

import numpy as np
from numba import njit
from scipy.ndimage import label
from scipy.optimize import linear_sum_assignment
from scipy.spatial.transform import Rotation

from physics.light import Light
from physics.motion import Motion
from physics.odometry import BETTER, Views, apparent_motion, views_of
from physics.seen_from import moved, pixel

# A point has moved where later, or before, one sees through it: what is there is farther, by more than this part.
THROUGH = 0.03
# A surface has moved if so much of it has. One that slides along itself is seen through beside its edges alone.
MOVED = 0.03
# Or if less of it than this lies on what is seen before or after, to this part of its range: what turns in its place.
LAID, ON = 0.4, 0.002
# Things of fewer pixels than this part of the image are none; no more than so many are followed.
SMALL, MANY = 0.004, 6
# From one frame to the next a thing's middle moves by less than this part of its range.
FAR = 0.5
# Where more than this is not laid on surfaces it may have turned: about any axis of the camera's, radians.
POOR = 0.3
TURNS = tuple(sign * angle * axis for axis in np.eye(3) for angle in (0.2, 0.5) for sign in (-1, 1))


@dataclass(frozen=True, eq=False)
class Body:
    """A rigid thing. motion: of a camera for which it stands still. there: (F, H, W) which pixels see it."""

    motion: Motion
    there: np.ndarray


def bodies(light: Light) -> tuple[Body, ...]:
    """What most of the view is of, first, and up to `MANY` things that move otherwise; in all frames of the light."""
    views, still = views_of(light), apparent_motion(light)
    apart = _things(*_moved(views, still), light.surfaces)

    def size(track: dict[int, int]) -> int:
        return sum(np.count_nonzero(apart[i] == number) for i, number in track.items())

    tracks = sorted(_tracks(views, apart), key=size, reverse=True)
    found = [_body(views, apart, track, light.time_s) for track in tracks[:MANY]]
    rest = ~np.any([body.there for body in found], axis=0) if found else np.ones(light.range_m.shape, bool)
    return (Body(still, rest), *found)


def _moved(views: Views, still: Motion) -> tuple[np.ndarray, np.ndarray]:
    """(F, H, W) each: whether points were seen through in the frame before or after, from where the camera was; and
    whether they lie on what was seen there.
    """
    through, laid = (np.zeros(views.depth.shape, bool) for _ in range(2))
    at = still.start_from_camera
    for i, j in pairwise(range(len(through))):
        for here, there in ((i, j), (j, i)):
            step = np.linalg.solve(at[there], at[here])
            seen = views.depth[there], views.normals[there], views.rays, views.intrinsics
            _compared(views.depth[here], *seen, step, through[here], laid[here])
    return through, laid


@njit(nogil=True, cache=True)
def _compared(depth, other, normals, rays, intrinsics, step, through, laid):
    """Mark pixels whose points the other image (H, W) sees through, with all pixels around where they would be; and
    those that lie on what it sees there.
    """
    height, width = depth.shape
    for v in range(height):
        for u in range(width):
            z = depth[v, u]
            if not z > 0:
                continue
            px, py, pz = moved(step, z * rays[v, u, 0], z * rays[v, u, 1], z)
            if not pz > 0:
                continue
            column, row = pixel(intrinsics, px, py, pz)
            column, row = int(np.rint(column)), int(np.rint(row))
            if row < 1 or column < 1 or row >= height - 1 or column >= width - 1:
                continue
            farther = True
            for below in range(row - 1, row + 2):
                for right in range(column - 1, column + 2):
                    there = other[below, right]
                    farther &= there > 0 and there > pz * (1 + THROUGH)
            through[v, u] |= farther
            there, ray, normal = other[row, column], rays[row, column], normals[row, column]
            dx, dy, dz = px - there * ray[0], py - there * ray[1], pz - there * ray[2]
            off = abs(normal[0] * dx + normal[1] * dy + normal[2] * dz)
            laid[v, u] |= there > 0 and off < ON * there


def _things(through: np.ndarray, laid: np.ndarray, surfaces: np.ndarray) -> np.ndarray:
    """(F, H, W) numbers, by frame, of what hangs together in the image of surfaces that moved; 0 elsewhere."""
    out = np.zeros(through.shape, np.int32)
    for i, pieces in enumerate(surfaces):
        sizes = np.maximum(np.bincount(pieces.ravel()), 1)
        gone, there = (np.bincount(pieces.ravel(), weights=of[i].ravel()) / sizes for of in (through, laid))
        elsewhere = (gone > MOVED) | (there < LAID)
        elsewhere[0] = False
        things, _ = label(elsewhere[pieces] | (through[i] & (pieces == 0)), np.ones((3, 3)))
        size = np.bincount(things.ravel())
        size[0] = 0
        out[i] = np.where((size >= SMALL * pieces.size)[things], things, 0)
    return out


def _tracks(views: Views, apart: np.ndarray) -> list[dict[int, int]]:
    """Things followed through frames: frame to number there."""
    tracks: list[dict[int, int]] = []
    open_tracks: list[dict[int, int]] = []
    for i in range(len(apart)):
        here = [n for n in np.unique(apart[i]) if n]
        middles = [views.middle(i, apart[i] == n) for n in here]
        ends = [views.middle(i - 1, apart[i - 1] == track[i - 1]) for track in open_tracks]
        away = np.full((len(ends), len(here)), 2 * FAR)
        for (a, end), (b, middle) in product(enumerate(ends), enumerate(middles)):
            away[a, b] = min(np.linalg.norm(end - middle) / np.linalg.norm(middle), 2 * FAR)
        pairs = [(a, b) for a, b in zip(*linear_sum_assignment(away), strict=True) if away[a, b] < FAR]
        for a, b in pairs:
            open_tracks[a][i] = here[b]
        begun = [{i: n} for k, n in enumerate(here) if k not in {b for _, b in pairs}]
        tracks += begun
        open_tracks = [open_tracks[a] for a, _ in pairs] + begun
    return tracks


def _body(views: Views, apart: np.ndarray, track: dict[int, int], time_s: np.ndarray) -> Body:
    """A thing that was followed, with its motion from one frame to the next."""
    there = np.zeros(apart.shape, bool)
    for i, number in track.items():
        there[i] = apart[i] == number
    frames = sorted(track)
    way, step = [np.eye(4)], np.eye(4)
    for i, j in pairwise(frames):
        before, after = views.middle(i, there[i]), views.middle(j, there[j])
        # What slides along itself lies on its surfaces wherever it is: then its middle tells.
        found = views.aligned(i, j, _about(before, after, np.zeros(3)), there)
        for begun in ((np.eye(4), step), TURNS):
            starts = (_about(before, after, one) if one.shape == (3,) else one for one in begun)
            other = min((views.aligned(i, j, start, there) for start in starts), key=_loss)
            found = other if _loss(other) < _loss(found) - BETTER else found
            if found[1] < POOR:
                break
        step = found[0]
        way.append(way[-1] @ step)
    return Body(Motion(np.asarray(time_s, float)[frames], np.array(way)), there)


def _loss(found: tuple[np.ndarray, float]) -> float:
    """Of a motion that was found."""
    return found[1]


def _about(before: np.ndarray, after: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """(4, 4) motion that takes one middle (3,) to another and turns about it."""
    out = np.eye(4)
    out[:3, :3] = Rotation.from_rotvec(turn).as_matrix()
    out[:3, 3] = before - out[:3, :3] @ after
    return out

"""A wall so far ahead that its light is of the shot before, seen wherever depth is unknown."""

from collections.abc import Sequence

import numpy as np
from scipy.constants import speed_of_light

from physics.folded import one_period_early
from physics.light import Light, Return
from physics.motion import Motion
from physics.odometry import camera_motion
from physics.rendering import Rendering
from physics.replicas import DARK, correlation

# A wall whose normal is so nearly across the ray is seen edge on.
LEAST_FACING = 0.05
# Of the most that a wall could show, what is too little to tell where it is; and what no division may meet.
TOLD, LEAST = 1e-3, 1e-12
# Camera motion by less than this turn, or than so many bins of light's way, tells no wall that stands still from one
# that goes along.
TURN, BINS = 0.02, 0.5


def normal_of(toward: tuple[float, float], tilt: tuple[float, float] = (0.0, 0.0)) -> np.ndarray:
    """(3,) n of planes n·X = d that lie d ahead in a direction.

    toward: azimuth, to the right of the optical axis, and elevation of that direction, radians. tilt: by what part of d
    a plane is nearer for each unit of the tangents, to the right and down, of rays about that direction.
    """
    azimuth, elevation = toward
    right = np.array([np.cos(azimuth), 0, -np.sin(azimuth)])
    ahead = np.array([np.cos(elevation) * np.sin(azimuth), -np.sin(elevation), np.cos(elevation) * np.cos(azimuth)])
    return ahead + tilt[0] * right + tilt[1] * np.cross(ahead, right)


def planes(normal: np.ndarray, away_m: np.ndarray, motion: Motion | None, time_s: np.ndarray) -> tuple:
    """(F, 3) normals and (F,) distances, metres, in frames' cameras of planes n·X = d that stand still.

    normal: (3,) n in the camera's frame at the session's beginning. away_m: (F,) d from where it was. motion: how the
    camera moves meanwhile, None for planes that go along with it.
    """
    if motion is None:
        return np.broadcast_to(normal, (len(away_m), 3)), away_m
    at = motion.start_from_camera[motion.nearest(time_s)]
    return normal @ at[:, :3, :3], away_m - at[:, :3, 3] @ normal


def seen_through(light: Light, normals: np.ndarray, away_m: np.ndarray, anywhere: bool = False) -> list[Return]:
    """What white planes n·X = d, normals (F, 3) and metres (F,), send back where depth is unknown; none where it is
    known, unless anywhere. Strength cosθ/r² as in the nominal model.
    """
    seen = ~(light.range_m > 0) | anywhere
    if not seen.any():
        return []
    ranges, strength = met(light.rays, normals, away_m)
    return [Return(ranges.astype(np.float32), (seen * strength).astype(np.float32))]


def met(rays: np.ndarray, normals: np.ndarray, away_m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(F, H, W) metres along rays (H, W, 3) to white planes, see `planes`, and what they send back; 0 where edge on."""
    rays = rays / np.linalg.norm(rays, axis=-1, keepdims=True)
    cosine = np.einsum("hwk,fk->fhw", rays, normals / np.linalg.norm(normals, axis=1, keepdims=True))
    away = (away_m / np.linalg.norm(normals, axis=1))[:, None, None]
    there = (cosine > LEAST_FACING) & (away > 0)
    ranges = np.where(there, away / np.where(there, cosine, 1), 0)
    return ranges, np.where(there, cosine / np.where(there, ranges, 1) ** 2, 0)


def toward_unknown(light: Light, motion: Motion | None) -> tuple[float, float]:
    """Azimuth and elevation, radians, of the mean direction in which depth is unknown; (0, 0) where it is known.

    motion: in the camera's frame at the session's beginning by how it moved; None: in its own.
    """
    unknown = ~(light.range_m > 0)
    each = np.einsum("fhw,hwk->fk", unknown, light.rays / np.linalg.norm(light.rays, axis=-1, keepdims=True))
    if motion is not None:
        at = motion.start_from_camera[motion.nearest(light.time_s)]
        each = np.einsum("fij,fj->fi", at[:, :3, :3], each)
    x, y, z = each.sum(axis=0)
    return float(np.arctan2(x, z)), float(-np.arctan2(y, np.hypot(x, z)))


def walls(
    excess: np.ndarray, expected: np.ndarray, rendering: Rendering, period_s: float, smears_s: Sequence[float]
) -> list[dict[str, float]]:
    """Where walls are that are seen where depth is unknown and explain most of an excess (F, P, T).

    Across the direction in which it is unknown, that go along with the camera and, where it moves, that stand still;
    for each of the laser's periods' standard deviations, seconds. None where nothing is unknown.
    """
    found = []
    for still, way in ways(rendering):
        toward = toward_unknown(rendering.light, way)
        for smear_s in smears_s:
            depth = _likeliest(excess, expected, rendering, toward, way, (period_s, smear_s))
            if depth is not None:
                place = {"depth": depth, "azimuth": toward[0], "elevation": toward[1]}
                found.append(place | {"smear": smear_s, "still": still})
    return found


def ways(rendering: Rendering) -> list[tuple[float, Motion | None]]:
    """How far things may move before the camera: 0 and None, along with it; where it moves 1 and how, they stand."""
    motion = camera_motion(rendering.light)
    stands = [(1.0, motion)] if _moves(motion, speed_of_light / 2 * rendering.clock.bin_width_s) else []
    return [(0.0, None), *stands]


def _moves(motion: Motion, bin_m: float) -> bool:
    """Whether the camera moves enough to tell a wall that stands still from one that goes along."""
    at = motion.start_from_camera
    turned = np.einsum("ij,fij->f", at[0, :3, :3], at[:, :3, :3])  # Trace of the turn since the first.
    return bool((turned < 1 + 2 * np.cos(TURN)).any() or (np.ptp(at[:, :3, 3], axis=0) > BINS * bin_m).any())


def _likeliest(
    excess: np.ndarray,
    expected: np.ndarray,
    rendering: Rendering,
    toward: tuple[float, float],
    motion: Motion | None,
    laser_s: tuple[float, float],
) -> float | None:
    """Metres to a wall in a direction that explains most of an excess; None where none is seen.

    laser_s: period and its standard deviation. Matched filters for white noise (Turin 1960, IRE Trans. Inf. Theory 6,
    311) at all whole bins at once, as correlations: a wall so much farther is the same light so much later.
    """
    clock, light = rendering.clock, rendering.light
    metres = clock.bin_width_s * speed_of_light / 2
    middle_s = clock.bins * clock.bin_width_s / 2 - float(np.mean(clock.time_zero_s))
    away_m = speed_of_light / 2 * (laser_s[0] + middle_s)
    where = planes(normal_of(toward), np.full(light.frames, away_m), motion, light.time_s)
    seen = one_period_early(rendering, seen_through(light, *where), *laser_s)
    if seen is None:
        return None
    noise = 1 / np.maximum(expected, DARK)
    promised = correlation(seen, excess * noise).sum(axis=(0, 1))
    information = correlation(seen**2, noise).sum(axis=(0, 1))
    evidence = np.maximum(promised, 0) ** 2 / np.maximum(information, TOLD * information.max(initial=0) + LEAST)
    best = int(np.argmax(evidence))
    return away_m + (best - (clock.bins - 1)) * metres if evidence[best] > 0 else None

"""Light that reaches surfaces by way of one patch outside the view, which scatters it on."""

from functools import lru_cache
from itertools import product

import numpy as np

from physics.light import Light
from physics.outside_plane import facing
from physics.rendering import Rendering
from physics.walls_around import likely_distances
from physics.workers import in_parallel

# Half the size of a patch, as a part of its distance from the sensor: nothing is nearer to all of it than that.
HALF_SIZE = 0.1
# How far ahead of the sensor fits begin, as a part of how far aside.
AHEAD = 0.4


@lru_cache(maxsize=2)
def by_way_of_patch(
    light: Light, x: float, y: float, z: float, stands: bool, dimmed: bool = False
) -> tuple[np.ndarray, np.ndarray]:
    """Half the path (F, H, W) sensor, patch, surface, sensor, and its strength for a patch of unit strength.

    x, y, z: metres from the sensor in the camera's frame when the session began. stands: whether it stays where it is
    in the world, where the camera's motion is known, or goes along with the camera. To read only. A matt surface at X
    is lit by cosθ'/(|X - q|² + h²), θ' its incidence from the patch at q, h the patch's half size. dimmed: in place of
    cosθ' it goes with what the surface sends back directly, cosθ/r², as of light that goes the other way round.
    """
    half_path, strength = np.zeros_like(light.range_m), np.zeros_like(light.range_m)
    unit = light.rays / np.linalg.norm(light.rays, axis=-1)[..., None]
    areas = None if dimmed else facing(light)

    def one(i: int) -> None:
        q = np.array([x, y, z])
        if stands and light.motion is not None:
            moved = light.motion.start_from_camera[light.motion.nearest(light.time_s[i : i + 1])[0]]
            q = moved[:3, :3].T @ (q - moved[:3, 3])
        ranges = light.range_m[i]
        there = (ranges > 0) & np.isfinite(ranges) & (light.returns[0].strength[i] > 0)
        way = q - unit * np.where(there, ranges, 0)[..., None]
        apart = np.linalg.norm(way, axis=-1)
        sends = light.returns[0].strength[i]
        if not dimmed:
            size = np.linalg.norm(areas[i], axis=-1)
            cosine = np.maximum((way * areas[i]).sum(axis=-1), 0) / np.maximum(size * apart, 1e-12)
            sends = light.reflectance[i] * cosine
        lit = sends / (apart**2 + (HALF_SIZE * np.linalg.norm(q)) ** 2)
        strength[i] = np.where(there & np.isfinite(lit), lit, 0)
        half_path[i] = np.where(there, (ranges + apart + np.linalg.norm(q)) / 2, 0)

    in_parallel(one, range(light.frames))
    return half_path, strength


def likely_patches(excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
    """Where patches may be by way of which light is about as late as what is in excess: on all four sides."""
    found = []
    for away in likely_distances(excess, expected, rendering, most=1):
        for right, down in ((1, 0), (0, 1), (-1, 0), (0, -1)):
            place = {"patch_x": right * away, "patch_y": down * away, "patch_z": AHEAD * away}
            ways = product((0.0, 1.0) if rendering.light.motion is not None else (0.0,), (0.0, 1.0))
            found += [place | {"patch_stands": stands, "patch_dimmed": dimmed} for stands, dimmed in ways]
    return found

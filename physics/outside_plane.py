"""Light that reaches surfaces by way of a plane outside the view, which sends it on as a mirror image of the sensor."""

from functools import lru_cache

import numpy as np
from numba import njit

from physics.light import Light
from physics.normals import facing
from physics.workers import in_parallel

# Surfaces nearer to the outside plane than this part of its distance get less light of it in proportion, none behind;
# and all do while the sensor itself is nearer to it than this part of its distance at the beginning.
EDGE = 0.1


# Fits try strengths and change the plane in turn.
@lru_cache(maxsize=2)
def by_way_of_plane(
    light: Light, distance_m: float, azimuth_deg: float, tilt_deg: float, stands: bool = True, dimmed: bool = False
) -> tuple[np.ndarray, np.ndarray]:
    """Half the path (F, H, W) by way of a plane outside the view, and its strength for a perfect one; to read only.

    distance_m: from the sensor; azimuth_deg: its direction in the image, 0 to the right and 90 down; tilt_deg: by how
    much it leans ahead of the sensor; all three at the beginning of the camera's motion. stands: whether it stays where
    it is in the world, where that motion is known, or goes along with the camera. dimmed: whether what comes that way
    goes with what surfaces send back directly, in place of the mirror's own light.
    """
    azimuth, tilt = np.radians([azimuth_deg, tilt_deg])
    normal = np.array([np.cos(azimuth) * np.cos(tilt), np.sin(azimuth) * np.cos(tilt), np.sin(tilt)])
    half_path, strength = np.zeros_like(light.range_m), np.zeros_like(light.range_m)
    lengths, areas = np.linalg.norm(light.rays, axis=-1), None if dimmed else facing(light)

    def one(i: int) -> None:
        axis, away = normal, distance_m
        if stands and light.motion is not None:
            axis, away = light.motion.plane(normal, distance_m, float(light.time_s[i]))
        if not away > 0:
            return
        seen = light.range_m[i], light.returns[0].strength[i], light.reflectance[i]
        near = min(away / (EDGE * distance_m), 1)
        area, plane = np.zeros((0, 0, 3)) if dimmed else areas[i], (np.asarray(axis, float), away, near)
        _by_way(*seen, light.rays, lengths, area, *plane, half_path[i], strength[i])

    in_parallel(one, range(light.frames))
    return half_path, strength


@njit(nogil=True, cache=True)
def _by_way(ranges, direct, reflectance, rays, lengths, areas, axis, away, near, half_path, strength):
    """Fill half the path and the strength of one frame (H, W), 0 where nothing comes that way; dimmed without areas."""
    for v in range(ranges.shape[0]):
        for u in range(ranges.shape[1]):
            if not direct[v, u] > 0:
                continue
            along = ranges[v, u] / lengths[v, u]
            x, y, z = rays[v, u, 0] * along, rays[v, u, 1] * along, rays[v, u, 2] * along
            before = 1 - (x * axis[0] + y * axis[1] + z * axis[2]) / away
            if not before > 0:
                continue
            x, y, z = 2 * away * axis[0] - x, 2 * away * axis[1] - y, 2 * away * axis[2] - z
            square = x * x + y * y + z * z
            far, sends = np.sqrt(square), direct[v, u]
            if areas.size:
                area_x, area_y, area_z = areas[v, u, 0], areas[v, u, 1], areas[v, u, 2]
                size = np.sqrt(area_x * area_x + area_y * area_y + area_z * area_z)
                if not size > 0:
                    continue
                toward = max(area_x * x + area_y * y + area_z * z, 0.0)
                sends = reflectance[v, u] * toward / (size * far * square)
            strength[v, u] = sends * min(before / EDGE, 1.0) * near
            half_path[v, u] = (ranges[v, u] + far) / 2

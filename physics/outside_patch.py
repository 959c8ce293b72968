"""Light that reaches surfaces by way of one patch outside the view, which scatters it on."""

from functools import lru_cache
from itertools import product

import numpy as np
from numba import njit
from numpy.polynomial.hermite_e import hermegauss

from physics.light import Light, Return
from physics.normals import facing
from physics.rendering import Rendering
from physics.walls_around import likely_distances
from physics.workers import in_parallel

# Half the size of a patch, as a part of its distance from the sensor: nothing is nearer to all of it than that.
HALF_SIZE = 0.1
# How far ahead of the sensor fits begin, as a part of how far aside.
AHEAD = 0.4
# How many of its parts stand for all, up to so many times as wide as light goes in half a bin; of a wider one `MOST`.
# What is seen in bins is so right to 3 %, to 5 % at four times as wide (measured with a pulse about as wide as a bin).
PLACES, MOST = ((1.5, 3), (2.5, 5)), 9


def patch_returns(
    light: Light, x: float, y: float, z: float, wide: float, stands: bool, dimmed: bool, unit: float, bin_m: float
) -> list[Return]:
    """Returns by way of a patch of strength `unit`: see `by_way_of_patch`. bin_m: how far light goes in half a bin."""
    half_path, spread, strength = by_way_of_patch(light, x, y, z, wide, stands, dimmed)
    places = _places(next((n for times, n in PLACES if wide <= times * bin_m), MOST) if wide else 1)
    return [Return(half_path + np.float32(at) * spread, np.float32(unit * part) * strength) for at, part in places]


@lru_cache
def _places(n: int) -> tuple[tuple[float, float], ...]:
    """Where in a normal distribution, in standard deviations, n of its parts stand for all, and with what weight.

    What goes with the place by any power up to 2n - 1 is as on average (Gauss and Hermite's quadrature).
    """
    at, weight = hermegauss(n)
    return tuple(zip(at, weight / weight.sum(), strict=True))


@lru_cache(maxsize=2)
def by_way_of_patch(
    light: Light, x: float, y: float, z: float, wide: float, stands: bool, dimmed: bool = False
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Half the path sensor, patch, surface, sensor, its standard deviation, and strength of a unit, (F, H, W) each.

    x, y, z: metres from the sensor in the camera's frame when the session began. stands: whether it stays where it is
    in the world, where the camera's motion is known, or goes along with the camera. To read only. A matt surface at X
    is lit by cosθ'/(|X - q|² + h²), θ' its incidence from the patch at q, h the patch's half size. dimmed: in place of
    cosθ' it goes with what the surface sends back directly, cosθ/r², as of light that goes the other way round.

    wide: metres, of its parts about q, one standard deviation alike in every direction; each sends what one at q does.
    To second order in it half the path is longer by wide²/2 · (1/|q| + 1/|X - q|) on average, and differs by wide · |û
    + û'|/2, with û and û' from sensor and surface to q.
    """
    half_path, spread, strength = (np.zeros_like(light.range_m) for _ in range(3))
    lengths, areas = np.linalg.norm(light.rays, axis=-1), None if dimmed else facing(light)

    def one(i: int) -> None:
        q = np.array([x, y, z], float)
        if stands and light.motion is not None:
            moved = light.motion.start_from_camera[light.motion.nearest(light.time_s[i : i + 1])[0]]
            q = moved[:3, :3].T @ (q - moved[:3, 3])
        seen = light.range_m[i], light.returns[0].strength[i], light.reflectance[i]
        area = np.zeros((0, 0, 3)) if dimmed else areas[i]
        _by_way(*seen, light.rays, lengths, area, q, wide, half_path[i], spread[i], strength[i])

    in_parallel(one, range(light.frames))
    return half_path, spread, strength


@njit(nogil=True, cache=True)
def _by_way(ranges, direct, reflectance, rays, lengths, areas, q, wide, half_path, spread, strength):
    """Fill what `by_way_of_patch` tells of one frame (H, W), 0 where nothing comes that way; dimmed without areas."""
    away = np.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2])
    for v in range(ranges.shape[0]):
        for u in range(ranges.shape[1]):
            if not (direct[v, u] > 0 and 0 < ranges[v, u] < np.inf):
                continue
            along = ranges[v, u] / lengths[v, u]
            x, y, z = q[0] - rays[v, u, 0] * along, q[1] - rays[v, u, 1] * along, q[2] - rays[v, u, 2] * along
            square = x * x + y * y + z * z
            apart, sends = np.sqrt(square), direct[v, u]
            if areas.size:
                area_x, area_y, area_z = areas[v, u, 0], areas[v, u, 1], areas[v, u, 2]
                size = np.sqrt(area_x * area_x + area_y * area_y + area_z * area_z)
                toward = max(area_x * x + area_y * y + area_z * z, 0.0)
                sends = reflectance[v, u] * toward / max(size * apart, 1e-12)
            lit = sends / (square + (HALF_SIZE * away) ** 2)
            strength[v, u] = lit if np.isfinite(lit) else 0.0
            longer = wide**2 * (1 / max(away, wide) + 1 / max(apart, wide)) if wide > 0 else 0.0
            half_path[v, u] = (ranges[v, u] + apart + away + longer) / 2
            # Half of |û + û'|: the cosine of half the angle between both.
            both = (q[0] * x + q[1] * y + q[2] * z) / max(away * apart, 1e-12)
            spread[v, u] = wide * np.sqrt(max((1 + both) / 2, 0.0))


def likely_patches(excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
    """Where patches may be by way of which light is about as late as what is in excess: on all four sides."""
    found = []
    for away in likely_distances(excess, expected, rendering, most=1):
        for right, down in ((1, 0), (0, 1), (-1, 0), (0, -1)):
            place = {"patch_x": right * away, "patch_y": down * away, "patch_z": AHEAD * away}
            ways = product((0.0, 1.0) if rendering.light.motion is not None else (0.0,), (0.0, 1.0))
            found += [place | {"patch_stands": stands, "patch_dimmed": dimmed} for stands, dimmed in ways]
    return found

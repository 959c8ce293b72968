"""What a plane outside the view sends on to surfaces, worked out where the session began."""

import numpy as np

from physics.effect import Values
from physics.single_photons.world import World

# Targets nearer to the plane than this part of its distance are lit in proportion, those behind it not at all;
# so are all while the sensor is nearer to it than this part of its distance when the session began.
EDGE = 0.1


def plane_light(
    point_m: np.ndarray, normal: np.ndarray, albedo: np.ndarray, sends: np.ndarray, world: World, values: Values
) -> tuple[np.ndarray, np.ndarray]:
    """(N,) light that N points (N, 3) send back of what comes by way of the plane, and how far (N,) it came, metres.

    sends: (N,) what they send back directly, which it goes with where the plane's is dimmed.
    """
    azimuth, tilt = np.radians([values["outside_azimuth"], values["outside_tilt"]])
    distance = values["outside_distance"]
    axis = np.array([np.cos(azimuth) * np.cos(tilt), np.sin(azimuth) * np.cos(tilt), np.sin(tilt)])
    stands = values["outside_stands"] and world.start_from_camera is not None
    moved = world.start_from_camera if stands else np.eye(4)
    sensor, point = moved[:3, 3], point_m @ moved[:3, :3].T + moved[:3, 3]
    normal = normal @ moved[:3, :3].T
    away, gap = distance - sensor @ axis, distance - point @ axis
    before = (gap > 0) & (away > 0)
    gap = np.where(before, gap, 1.0)
    behind = point + 2 * gap[:, None] * axis - sensor
    # The straight way to the image crosses the plane where the real one turns.
    turn = sensor + behind * (away / np.where(before, behind @ axis, 1.0))[:, None]
    back = turn - point
    cosine = (back * normal).sum(axis=1) / np.linalg.norm(back, axis=1)
    far = np.linalg.norm(behind, axis=1)
    nearness = np.minimum(gap / (EDGE * max(away, 1e-12)), 1) * min(away / (EDGE * distance), 1)
    light = sends if values["outside_dimmed"] else albedo * np.clip(cosine, 0, None) / far**2
    return np.where(before, values["outside"] * light * nearness, 0), far

"""Photons that go by way of one patch outside the view."""

import numpy as np

from physics.effect import Values
from physics.single_photons.world import World

# Half the size of a patch, as a part of its distance from the sensor.
HALF_SIZE = 0.1


def patch_light(
    point: np.ndarray, normal: np.ndarray, albedo: np.ndarray, direct: np.ndarray, world: World, values: Values
) -> tuple[np.ndarray, np.ndarray]:
    """(N,) light, and (N,) metres from the sensor, of points (N, 3) by way of the patch.

    They face along normals (N, 3) and send `direct` (N,) back of light that comes straight.
    """
    where = np.array([values["patch_x"], values["patch_y"], values["patch_z"], 1.0])
    if values["patch_stands"] and world.start_from_camera is not None:
        where = np.linalg.solve(world.start_from_camera, where)
    patch = where[:3]
    apart = np.sqrt(((point - patch) ** 2).sum(axis=1))
    cosine = np.clip(((patch - point) * normal).sum(axis=1) / apart, 0, 1)
    wide = HALF_SIZE * np.linalg.norm(patch)
    sends = direct if values["patch_dimmed"] else albedo * cosine
    return values["patch"] * sends / (apart**2 + wide**2), np.linalg.norm(patch) + apart

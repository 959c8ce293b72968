"""Photons that go by way of one patch outside the view."""

import numpy as np

from physics.effect import Values
from physics.single_photons.world import World

# Half the size of a patch, as a part of its distance from the sensor.
HALF_SIZE = 0.1


def patch_light(
    point: np.ndarray, normal: np.ndarray, albedo: np.ndarray, direct: np.ndarray, world: World, values: Values
) -> np.ndarray:
    """(N,) light of points (N, 3) by way of the patch.

    They face along normals (N, 3) and send `direct` (N,) back of light that comes straight.
    """
    patch = _middle(world, values)
    apart = np.sqrt(((point - patch) ** 2).sum(axis=1))
    cosine = np.clip(((patch - point) * normal).sum(axis=1) / apart, 0, 1)
    half = HALF_SIZE * np.linalg.norm(patch)
    sends = direct if values["patch_dimmed"] else albedo * cosine
    return values["patch"] * sends / (apart**2 + half**2)


def patch_way(point: np.ndarray, world: World, values: Values, rng: np.random.Generator) -> np.ndarray:
    """(N,) metres from the sensor to points (N, 3) by way of the patch, of a part of it that is drawn for each."""
    part = _middle(world, values) + values["patch_wide"] * rng.normal(size=point.shape)
    return np.linalg.norm(part, axis=1) + np.linalg.norm(point - part, axis=1)


def _middle(world: World, values: Values) -> np.ndarray:
    """(3,) where the patch is in the camera's frame."""
    where = np.array([values["patch_x"], values["patch_y"], values["patch_z"], 1.0])
    if values["patch_stands"] and world.start_from_camera is not None:
        where = np.linalg.solve(world.start_from_camera, where)
    return where[:3]

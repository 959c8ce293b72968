"""Surfaces and a trajectory become views: rays through every pixel."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from physics.geometry import pixel_rays
from physics.scene.material import Material
from physics.scene.shading import coded, shaded
from physics.scene.surfaces import Surface
from physics.scene.trajectory import Trajectory
from physics.scene.view import View, Views


@dataclass(frozen=True, eq=False)
class Thing:
    """A surface of a material."""

    surface: Surface
    material: Material


def cast(
    things: Sequence[Thing], trajectory: Trajectory, intrinsics: np.ndarray, size: tuple[int, int], meta: dict
) -> Views:
    """Views of opaque things from every pose, with a grid of `size` width, height."""
    rays = pixel_rays(intrinsics, (size[1], size[0]))

    def views() -> Iterator[View]:
        for time_s, pose in zip(trajectory.time_s, trajectory.poses, strict=True):
            yield look(things, rays, pose, float(time_s))

    return Views(np.asarray(intrinsics, float), views(), len(trajectory.time_s), meta=meta)


def look(things: Sequence[Thing], rays: np.ndarray, pose: np.ndarray, time_s: float) -> View:
    """One view along rays (H, W, 3), of length 1 along z, from `pose` (4, 4), world from camera.

    In colour where any of the materials has one.
    """
    directions = rays.reshape(-1, 3) @ pose[:3, :3].T
    lengths = np.linalg.norm(directions, axis=-1)
    depth = np.full(len(directions), np.inf)
    reflectance, gloss, cosine = np.full((3, len(directions)), np.nan)
    colour, facing = np.full((2, len(directions), 3), np.nan)
    for thing in things:
        found, normals = thing.surface.hit(pose[:3, 3], directions)
        nearer = found < depth
        depth[nearer] = found[nearer]
        incidence = np.abs((normals[nearer] * directions[nearer]).sum(axis=-1)) / lengths[nearer]
        cosine[nearer] = np.minimum(incidence, 1)
        gloss[nearer] = thing.material.gloss(cosine[nearer])
        reflectance[nearer] = thing.material.reflectance
        colour[nearer] = coded(reflectance[nearer, None]) if thing.material.colour is None else thing.material.colour
        facing[nearer] = normals[nearer]
    depth[np.isinf(depth)] = np.nan
    images = [image.reshape(rays.shape[:2]).astype(np.float32) for image in (depth, reflectance, cosine, gloss)]
    glossy = images[3] if any(thing.material.specular for thing in things) else None
    rgb = None
    if any(thing.material.colour is not None for thing in things):
        rgb = shaded(colour, facing, directions).reshape(rays.shape)
    return View(time_s, images[0], images[1], images[2], glossy, rgb, pose)

"""Where the camera was when the session began, seen from where it is."""

import numpy as np
from scipy.special import expit

from physics.effect import Values
from physics.single_photons.world import World
from recordings.refusal import Refusal


def start_from_camera(world: World, what: str) -> np.ndarray:
    """(4, 4) rigid transform to the camera's frame of then; refuses where nobody says how it moved since.

    what: what stays where it is meanwhile, for that sentence.
    """
    if world.start_from_camera is None:
        raise Refusal(f"{what}: camera_pose is missing, expected the camera's way where photons are drawn one by one")
    return world.start_from_camera


def at_the_start(world: World, what: str) -> np.ndarray:
    """(H, W, 3) points where the first frame's camera has them; what: as for `start_from_camera`."""
    points = np.where(np.isfinite(world.points), world.points, 0.0)
    start = start_from_camera(world, what)
    return points @ start[:3, :3].T + start[:3, 3]


def in_a_ball(world: World, values: Values, name: str) -> np.ndarray:
    """(H, W) how far points are in the ball that these values place, with a rim a tenth of its radius wide."""
    away = np.linalg.norm(at_the_start(world, name) - [values[f"{name}_{axis}"] for axis in "xyz"], axis=-1)
    return expit(10 * (1 - away / values[f"{name}_size"]))

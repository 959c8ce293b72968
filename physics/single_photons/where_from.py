"""Where the camera was when the session began, seen from where it is."""

import numpy as np

from physics.single_photons.world import World
from recordings.refusal import Refusal


def start_from_camera(world: World, what: str) -> np.ndarray:
    """(4, 4) rigid transform to the camera's frame of then; refuses where nobody says how it moved since.

    what: what stays where it is meanwhile, for that sentence.
    """
    if world.start_from_camera is None:
        raise Refusal(f"{what}: camera_pose is missing, expected the camera's way where photons are drawn one by one")
    return world.start_from_camera

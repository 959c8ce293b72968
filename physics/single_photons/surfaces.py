"""Which surface a photon comes from: the numbers that the effects give them, which are no formula of either engine."""

import numpy as np

from physics.effect import Values
from physics.materials import materials, parts
from physics.segments import segments
from physics.single_photons.world import World


def surface_numbers(world: World, values: Values) -> np.ndarray:
    """(H, W) number of the surface at each pixel of this frame, told apart and followed in all frames."""
    every = [world.at(time) for time in world.times_s]
    frame = int(np.argmin(np.abs(world.times_s - world.time_s)))
    cameras = None if world.start_from_camera is None else np.stack([one.start_from_camera for one in every])
    found = segments(np.stack([one.range_m for one in every]), world.intrinsics, cameras)
    if values["told_by"]:
        of = materials(np.stack([one.reflectance for one in every]), found)
        found = of if values["told_by"] == 1 else parts(found, of)
    return found[frame]

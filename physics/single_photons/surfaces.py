"""Which surface a photon comes from: the numbers that the effects give them, which are no formula of either engine."""

import numpy as np

from physics.segments import segments
from physics.single_photons.world import World


def surface_numbers(world: World) -> np.ndarray:
    """(H, W) number of the surface at each pixel of this frame, told apart and followed in all frames."""
    ranges = np.stack([world.at(time).range_m for time in world.times_s])
    frame = int(np.argmin(np.abs(world.times_s - world.time_s)))
    return segments(ranges, world.intrinsics)[frame]

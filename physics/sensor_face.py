"""Light that comes back from the target to the sensor's face, and from there goes to the target once more."""

from dataclasses import replace

import numpy as np
from scipy.constants import speed_of_light
from scipy.signal import fftconvolve

from physics.arrivals import arrivals
from physics.clock import Clock
from physics.footprint import Footprints
from physics.kept import kept_with_light
from physics.light import Light, Return
from physics.normals import solid_angles
from physics.workers import in_parallel


@kept_with_light
def from_face(light: Light, footprints: Footprints, clock: Clock) -> np.ndarray:
    """(F, P, J) light that falls on the sensor's face and back on the target, for a face of π² m²; to read only."""
    lattice = clock.lattice
    direct = light.returns[0]
    forward = (1 / np.linalg.norm(light.rays, axis=-1)).astype(np.float32)
    seen = replace(light, returns=(Return(direct.range_m, direct.strength * forward),))
    target = arrivals(seen, footprints, clock).light
    onto_face = solid_angles(light) * forward
    again = np.empty_like(target)

    def one(i: int) -> None:
        lit = direct.strength[i] > 0
        at = direct.range_m[i][lit] * (2 / speed_of_light / lattice.step_s)
        fallen = (direct.strength[i] * onto_face)[lit]
        inside = at < lattice.size - 1
        knot, fallen = at[inside].astype(int), fallen[inside]
        later = fallen * (at[inside] - knot)
        delays = np.bincount(knot, fallen - later, lattice.size) + np.bincount(knot + 1, later, lattice.size)
        # Rounding of the transform must not make light negative.
        again[i] = np.maximum(fftconvolve(target[i], delays[None], axes=1)[:, : lattice.size], 0)

    in_parallel(one, range(light.frames))
    return again

"""What each zone receives from the patch: its response integrated over the disc."""

import numpy as np

from calibrate.simulated.bench import Bench
from physics.optics import Optics
from physics.radiometry import SHEETING_PER_SR, returned

# Nodes of the integral over the disc: with these it is exact to 1e-5 of the peak for SPADs behind this lens.
RINGS, SPOKES = 3, 12
# Discs are integrated in blocks of this many, which bounds the memory.
BLOCK = 4096


def disc_nodes(rings: int = RINGS, spokes: int = SPOKES) -> tuple[np.ndarray, np.ndarray]:
    """Nodes (Q, 2) in the unit disc and weights (Q,) that sum to 1.

    Gauss-Legendre in the squared radius, equal angles turned by half a step from ring to ring (Stroud 1971).
    """
    node, weight = np.polynomial.legendre.leggauss(rings)
    radius = np.sqrt((node + 1) / 2)[:, None]
    angle = 2 * np.pi * (np.arange(spokes) + 0.5 * np.arange(rings)[:, None]) / spokes
    nodes = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1).reshape(-1, 2)
    return nodes, np.repeat(weight / 2, spokes) / spokes


def from_points(optics: Optics, bench: Bench, points_m: np.ndarray, area_m2: float) -> np.ndarray:
    """(P, ...) photons per unit of gain from retroreflectors of `area_m2` at camera points (..., 3)."""
    seen = bench.to_lidar(points_m)
    return returned(optics.response(seen), SHEETING_PER_SR, area_m2, np.linalg.norm(seen, axis=-1))


def from_discs(optics: Optics, bench: Bench, centres_m: np.ndarray) -> np.ndarray:
    """(P, K) photons per unit of gain from whole patches centred at (K, 3), parallel to the image plane."""
    nodes, weights = disc_nodes()
    offsets = np.pad(bench.patch_radius_m * nodes, ((0, 0), (0, 1)))
    area = np.pi * bench.patch_radius_m**2
    blocks = np.split(centres_m[:, None], range(BLOCK, len(centres_m), BLOCK))
    discs = [from_points(optics, bench, block + offsets, area) @ weights for block in blocks]
    return np.concatenate(discs, axis=1)

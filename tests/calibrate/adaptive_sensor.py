"""A sensor for tests of the adaptive scan: turned, with texture, dead SPADs and noise; on a coarser grid than usual."""

from dataclasses import replace

import numpy as np

from calibrate.plan import ScanPlan
from calibrate.simulated.bench import Bench
from calibrate.simulated.disc import from_discs
from physics.optics import tmf882x_optics
from recordings.maps import ResponseMaps

RADIUS_PX = 17.75


def sensor(seed: int, columns: int = 54, rows: int = 30) -> ResponseMaps:
    """Full maps of one device in map 6."""
    rng = np.random.default_rng(seed)
    optics = tmf882x_optics(6, rng)
    alive = rng.random(optics.spads.masks.shape) > 0.03
    optics = replace(optics, spads=replace(optics.spads, masks=optics.spads.masks & alive), blur_m=7e-6)
    bench = Bench(lidar_rotation_deg=tuple(rng.normal(0, (2, 2, 5))))
    positions = bench.patch_positions(ScanPlan(columns, rows), rng)
    maps = from_discs(optics, bench, positions)
    maps = rng.poisson(2e6 * maps / maps.max() * rng.normal(1, 0.003, maps.shape[1])).astype(np.float32)
    names = np.array([f"{i:04d}" for i in range(len(positions))])
    return ResponseMaps(maps.reshape(3, 3, -1), *bench.project(positions).T, names)


def part_of(maps: ResponseMaps, cells: np.ndarray) -> ResponseMaps:
    """Those cells alone."""
    return replace(
        maps, responses=maps.responses[..., cells], xs=maps.xs[cells], ys=maps.ys[cells], cap_ids=maps.cap_ids[cells]
    )

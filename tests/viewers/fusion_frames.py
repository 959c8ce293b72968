"""A small session, made without fusion: what is shown does not depend on how it was found."""

import numpy as np

from fusion.cloud import Cloud
from fusion.fused import FusedFrame
from viewers.session_frame import SessionFrame, SessionRig

GRID, BINS, HEIGHT, WIDTH = (2, 3), 40, 36, 64
ZONES = GRID[0] * GRID[1]
INTRINSICS = np.array([[50.0, 0, 31.5], [0, 50.0, 17.5], [0, 0, 1]])
RANGE_M = np.tile((np.arange(BINS) - 4) * 0.1, (ZONES, 1))


def footprints():
    """A block of 10 × 16 pixels for each zone, columns running against the image's."""
    weights = np.zeros((ZONES, HEIGHT, WIDTH))
    for p in range(ZONES):
        row, column = divmod(p, GRID[1])
        top, left = 4 + 15 * row, 4 + 20 * (GRID[1] - 1 - column)
        weights[p, top : top + 10, left : left + 16] = 1
    return weights


def rig(**changes):
    return SessionRig(**{"zone_grid": GRID, "range_m": RANGE_M, "footprints": footprints(), **changes})


def frame(i, rate_hz=10.0, **changes):
    """Frame `i`: a wall that comes nearer, seen by a camera that moves sideways."""
    rng = np.random.default_rng(i)
    depth = np.full((HEIGHT, WIDTH), 2.0 - 0.01 * i, np.float32)
    depth[:3] = np.nan
    pose = np.eye(4)
    pose[0, 3] = 0.1 * i
    rgb = np.full((HEIGHT, WIDTH, 3), (200, 100, 50), np.uint8)
    zones = np.zeros((HEIGHT, WIDTH), np.uint8)
    fused = FusedFrame(i / rate_hz, depth, 0.1 * depth, np.full_like(depth, 0.5), zones, rgb, INTRINSICS, pose, "any")
    surface = np.full((ZONES, 2), np.nan)
    surface[:, 0] = 1.234 + 0.001 * i
    given = {
        "counts": rng.poisson(5.0, (ZONES, BINS)),
        "surface_m": surface,
        "surface_share": np.where(np.isfinite(surface), 1.0, np.nan),
        "fused": fused,
        "cloud": cloud(depth, rgb, i / rate_hz),
        "expected": np.full((ZONES, BINS), 5.0),
        "recorded_depth_m": depth,
    }
    return SessionFrame(i / rate_hz, **{**given, **changes})


def cloud(depth, rgb, timestamp_s):
    known = np.isfinite(depth)
    v, u = np.nonzero(known)
    z = depth[known]
    points = np.stack([(u - 31.5) / 50 * z, (v - 17.5) / 50 * z, z], axis=1).astype(np.float32)
    ones = np.ones(len(z), np.float32)
    return Cloud(points, ones, ones, np.zeros(len(z), np.uint8), rgb[known], timestamp_s)

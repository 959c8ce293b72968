"""A small rig: four zones side by side, 48 bins, a camera of 24 × 32 pixels."""

import json
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from fusion.range_response import range_response
from fusion.sight import sight
from physics.pulse import two_piece_pulse
from physics.sensor import SensorModel
from recordings.maps import ResponseMaps

WIDTH_S = 2.6e-10
INTRINSICS = np.array([[30.0, 0, 15.5], [0, 30, 11.5], [0, 0, 1]])


@dataclass(frozen=True, repr=False)
class Rig:
    """Without its arrays written out where a test fails."""

    maps: Any
    sensor: Any
    sight: Any
    response: Any


@pytest.fixture(scope="session")
def maps():
    """Four bells in an image of 64 × 48."""
    x, y = (g.ravel() for g in np.meshgrid(np.linspace(-4, 68, 25), np.linspace(-4, 52, 20)))
    # Off a regular grid, whose triangles would be ambiguous.
    x, y = np.array([x, y]) + np.random.default_rng(1).uniform(-0.3, 0.3, (2, x.size))
    centres = [(20, 14), (44, 14), (20, 34), (44, 34)]
    bells = np.stack([np.exp(-(((x - a) / 9) ** 2) - ((y - b) / 8) ** 2) for a, b in centres])
    scale = np.array([1.0, 0.7, 0.9, 0.8])[:, None] * 1e4
    meta = {"image_size": [64, 48], "calibration_range_m": 0.8}
    return ResponseMaps((bells * scale).reshape(2, 2, -1), x, y, np.arange(x.size).astype(str), json.dumps(meta))


@pytest.fixture(scope="session")
def sensor():
    return SensorModel(
        name="small",
        zone_grid=(2, 2),
        bins=48,
        bin_width_s=WIDTH_S,
        time_zero_s=2e-9 + np.array([0, 3e-11, -5e-11, 2e-11]),
        pulse=two_piece_pulse(1.2e-10, 2.5e-10, WIDTH_S / 16),
        laser_cycles=100_000,
        background_counts=np.full(4, 3.0),
    )


@pytest.fixture(scope="session")
def rig(maps, sensor):
    where = sight(maps, (24, 32), INTRINSICS)
    return Rig(maps, sensor, where, range_response(sensor))

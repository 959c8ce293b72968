"""A box that moves before a slanted wall, seen by four zones: small enough to be explained within a second or two."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from mismatch.open_simulation import simulation_of
from physics.clock import Clock
from physics.effects import find_effect
from physics.footprint import footprints
from physics.light import direct_light
from physics.nominal import ForwardModel
from physics.pulse import ImpulseResponse, tailed_pulse
from recordings.maps import ResponseMaps
from recordings.recording import Recording

FRAMES, ROWS, COLUMNS, ZONES, BINS = 24, 10, 17, 4, 48
WIDTH_S = 0.26e-9
PEAK = 3000.0
CYCLES = 4e4
INTRINSICS = np.array([[12.0, 0, 8.0], [0, 12.0, 4.5], [0, 0, 1]])
BACKGROUND = np.array([2.0, 3.0, 4.0, 5.0])


def depths(frames=FRAMES):
    """(F, H, W) metres: a wall that recedes to the right, a box that comes and goes, a sensor that sways."""
    v, u = np.indices((ROWS, COLUMNS))
    out = np.empty((frames, ROWS, COLUMNS))
    for i in range(frames):
        wall = 0.9 + 0.03 * (u - 8) + 0.02 * (v - 4.5) + 0.15 * np.sin(0.9 * i)
        x, y = 8 + 6 * np.sin(0.5 * i), 4.5 + 3 * np.cos(0.7 * i)
        box = (np.abs(u - x) < 3) & (np.abs(v - y) < 2.5)
        out[i] = np.where(box, 0.5 + 0.08 * np.cos(0.4 * i), wall)
    return out


@pytest.fixture(scope="session")
def maps():
    rng = np.random.default_rng(1)
    x, y = np.meshgrid(np.linspace(20, 820, 12), np.linspace(15, 465, 9))
    # Off a regular grid, whose triangles would be ambiguous.
    x, y = x + rng.uniform(-3, 3, x.shape), y + rng.uniform(-3, 3, y.shape)
    centres = [(250, 150), (600, 160), (260, 330), (580, 340)]
    blobs = [np.exp(-(((x - cx) / 120) ** 2) - ((y - cy) / 90) ** 2) for cx, cy in centres]
    responses = np.stack(blobs).reshape(2, 2, -1) * 1e5 * rng.uniform(0.8, 1, (2, 2, 1))
    return ResponseMaps(responses, x.ravel(), y.ravel(), np.arange(x.size).astype(str))


@pytest.fixture(scope="session")
def rig(maps):
    """Scene and sensor. expected(effects): (F, P, T) counts; recording(counts, **fields): what was seen of them."""
    rng = np.random.default_rng(2)
    depth = depths()
    reflectance = np.broadcast_to(rng.uniform(0.4, 1, depth.shape[1:]), depth.shape)
    times = np.arange(FRAMES) / 15
    light = direct_light(depth, INTRINSICS, reflectance, time_s=times, laser_cycles=CYCLES)
    pulse = tailed_pulse(0.2e-9, 0.3e-9, 0.4e-9, 0.1, step_s=WIDTH_S / 16)
    zero = 2e-9 + np.array([0, 0.031e-9, -0.05e-9, 0.017e-9])
    clock = Clock(WIDTH_S, BINS, zero, ImpulseResponse(pulse.time_s, pulse.probability))
    model = ForwardModel(light, footprints(maps, depth.shape[1:]), clock, BACKGROUND)
    gain = PEAK / (model.expected(1.0) - BACKGROUND[:, None]).max()

    def expected(*effects):
        return model.expected(gain, effects)

    def recording(counts, **fields):
        seen = {
            "counts": np.asarray(counts).astype(np.uint32), "zone_grid": np.array([2, 2]), "bin_width_s": WIDTH_S,
            "time_zero_s": zero, "timestamp_s": times, "laser_cycles": CYCLES, "irf_time_s": pulse.time_s,
            "irf": pulse.probability, "background_counts": BACKGROUND, "depth_m": depth, "reflectance": reflectance,
            "intrinsics": INTRINSICS, "image_size": np.array([COLUMNS, ROWS]), "meta_json": json.dumps({}),
        }  # fmt: skip
        seen |= fields
        arrays = {n: v if v is None or isinstance(v, str) else np.asarray(v) for n, v in seen.items()}
        return Recording(**arrays)

    return SimpleNamespace(expected=expected, recording=recording, maps=maps, gain=gain)


@pytest.fixture(scope="session")
def simulated(rig):
    """simulated(counts): the simulation beside these counts."""
    return lambda counts: simulation_of(rig.recording(counts), rig.maps)[0]


@pytest.fixture(scope="session")
def drawn(rig, simulated):
    """drawn(seed, id, **values): the simulation beside Poisson counts under one effect, or none."""

    def draw(seed, name=None, **values):
        effects = () if name is None else (find_effect(name).at(**values),)
        return simulated(np.random.default_rng(seed).poisson(rig.expected(*effects)))

    return draw


@pytest.fixture(scope="session")
def fluctuating(rig, simulated):
    """fluctuating(seed, factors): the simulation beside Poisson counts, the light of each frame times a factor."""
    signal = rig.expected() - BACKGROUND[:, None]

    def draw(seed, factors):
        mean = np.maximum(factors, 0)[:, None, None] * signal + BACKGROUND[:, None]
        return simulated(np.random.default_rng(seed).poisson(mean))

    return draw

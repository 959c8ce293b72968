"""A small scene and sensor, and the nominal model written out pixel by pixel: the oracle of the fast one."""

from types import SimpleNamespace

import numpy as np
import pytest

from physics.clock import Clock
from physics.footprint import footprints
from physics.light import direct_light
from physics.nominal import ForwardModel
from physics.pulse import ImpulseResponse, tailed_pulse
from physics.rendering import Rendering
from recordings.maps import ResponseMaps

C = 299_792_458.0


def slow_model(light, weights, bin_width_s, bins, time_zero_s, pulse):
    """(F, P, T) signal at gain 1: a sum over pixels, each with the overlap of every step and every bin."""
    step = pulse.time_s[1] - pulse.time_s[0]
    starts = np.arange(bins) * bin_width_s
    out = np.zeros((light.frames, len(weights), bins))
    direct = light.returns[0]
    for f in range(light.frames):
        for p in range(len(weights)):
            for (v, u), w in np.ndenumerate(weights[p]):
                arrival = time_zero_s[p] + 2 * float(direct.range_m[f, v, u]) / C
                low = arrival + pulse.time_s - step / 2
                overlap = np.minimum(low + step, starts[:, None] + bin_width_s) - np.maximum(low, starts[:, None])
                share = (np.clip(overlap, 0, None) / step) @ pulse.probability
                out[f, p] += w * float(direct.strength[f, v, u]) * share
    return out


@pytest.fixture
def maps():
    rng = np.random.default_rng(1)
    x, y = np.meshgrid(np.linspace(40, 800, 12), np.linspace(30, 450, 9))
    # Off a regular grid, whose triangles would be ambiguous.
    x, y = x + rng.uniform(-3, 3, x.shape), y + rng.uniform(-3, 3, y.shape)
    centres = [(250, 150), (600, 160), (260, 330), (580, 340)]
    blobs = [np.exp(-(((x - cx) / 120) ** 2) - ((y - cy) / 90) ** 2) for cx, cy in centres]
    responses = np.stack(blobs).reshape(2, 2, -1) * 1e5 * rng.uniform(0.8, 1, (2, 2, 1))
    return ResponseMaps(responses, x.ravel(), y.ravel(), np.arange(x.size).astype(str))


@pytest.fixture
def small(maps):
    """3 frames of 6 × 10 pixels, 4 zones, 40 bins; laser shots so few that pile-up shows."""
    rng = np.random.default_rng(2)
    shape = (3, 6, 10)
    light = direct_light(
        rng.uniform(0.3, 1.2, shape),
        np.array([[7.5, 0, 4.5], [0, 7.5, 2.5], [0, 0, 1]]),
        rng.uniform(0.2, 1, shape),
        rng.uniform(0.3, 1, shape),
        time_s=np.array([0.0, 0.1, 0.2]),
        laser_cycles=2e4,
    )
    width = 0.26e-9
    pulse = tailed_pulse(0.12e-9, 0.25e-9, 0.4e-9, 0.2, step_s=width / 16)
    zero = 2e-9 + np.array([0, 0.031e-9, -0.05e-9, 0.017e-9])
    clock = Clock(width, 40, zero, ImpulseResponse(pulse.time_s, pulse.probability))
    return SimpleNamespace(light=light, footprints=footprints(maps, shape[1:]), clock=clock)


@pytest.fixture
def approached(small):
    """A wall that draws near, from 1.2 to 0.6 m: its model, and its rendering at a gain of 10,000."""
    rows, columns = small.light.range_m.shape[1:]
    depth = np.linspace(1.2, 0.6, 3)[:, None, None] * np.ones((3, rows, columns))
    light = direct_light(depth, small.light.intrinsics, time_s=small.light.time_s)
    model = ForwardModel(light, small.footprints, small.clock, 4.0)
    return model, Rendering(light, small.footprints, small.clock, 1e4, background=np.full((1, 1), 4.0))

"""Replicas are found where a scene has second returns, drawn with their noise."""

from dataclasses import replace

import numpy as np
import pytest

from physics.light import Return, direct_light
from physics.nominal import ForwardModel
from physics.rendering import Rendering
from physics.replicas import replicas

GAIN = 3e4
BIN_M = 0.26e-9 * 299_792_458 / 2


@pytest.fixture
def wall(small):
    """A wall that draws nearer, in a window of 40 bins."""
    depth = np.linspace(0.35, 0.65, 3)[:, None, None] * np.ones((3, 6, 10))
    return direct_light(depth, small.light.intrinsics, time_s=small.light.time_s)


def drawn(small, light, spacing, part, falloff=2.0):
    """Excess over the model of `light`, that model, and the rendering: counts with a second return of every pixel."""
    direct = light.returns[0]
    there = direct.range_m + np.float32(spacing)
    second = Return(there, (part * direct.strength * (direct.range_m / there) ** falloff).astype(np.float32))
    made = ForwardModel(replace(light, returns=(direct, second)), small.footprints, small.clock, 3.0).expected(GAIN)
    nominal = ForwardModel(light, small.footprints, small.clock, 3.0).expected(GAIN)
    rendering = Rendering(light, small.footprints, small.clock, GAIN, background=3.0)
    return np.random.default_rng(4).poisson(made) - nominal, nominal, rendering


@pytest.mark.parametrize("spacing", [0.21, 0.4, -0.2])
def test_a_second_return_is_found_where_it_is(small, wall, spacing):
    found = replicas(*drawn(small, wall, spacing, 0.1), falloff=2.0)
    assert abs(found[0].spacing_m - spacing) < 0.4 * BIN_M
    # The inverse square explains it better than none.
    assert found[0].evidence > replicas(*drawn(small, wall, spacing, 0.1), falloff=0.0)[0].evidence


def test_a_faint_one_is_found_in_the_dark(small, wall):
    """A ten thousandth of a pulse, in bins where nothing else is, beside the pulse itself, which is off by far more."""
    frame, zone, at = np.ogrid[:3, :4, : small.clock.bins]
    arrival = 8.3 + 4 * frame + 0.5 * zone

    def light(late):
        return 2e4 * np.exp(-((at - arrival - late) ** 2) / 2)

    rng = np.random.default_rng(4)
    excess = rng.poisson(light(0.05) + 1e-4 * light(15)) - light(0)
    rendering = Rendering(wall, small.footprints, small.clock, GAIN, background=np.zeros(()))
    found = replicas(excess, light(0), rendering, falloff=0.0)
    assert min(abs(one.spacing_m - 15 * BIN_M) for one in found) < 0.2 * BIN_M


def test_it_says_which_surfaces_have_one(small):
    depth = np.where(np.arange(10) < 5, 0.35, 0.9) * np.ones((3, 6, 10))
    light = direct_light(depth, small.light.intrinsics, time_s=small.light.time_s)
    near = (light.range_m[0] < 0.6)[None]
    one = replicas(*drawn(small, light, 0.2, 0.2 * near), falloff=2.0)[0]
    assert abs(one.spacing_m - 0.2) < 0.5 * BIN_M
    assert one.nearest_m < 0.4
    assert 0.4 < one.farthest_m < 0.9


def test_nothing_in_excess_has_none(small, wall):
    _, nominal, rendering = drawn(small, wall, 0.3, 0.1)
    assert replicas(np.zeros_like(nominal), nominal, rendering, falloff=2.0) == []

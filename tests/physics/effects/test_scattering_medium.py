"""Fog against a sum over pixels and layers, and its limits."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from physics.effects.scattering_medium import effect
from physics.light import Return, direct_light
from physics.nominal import ForwardModel


@pytest.fixture
def model(small):
    return ForwardModel(small.light, small.footprints, small.clock)


def test_without_backscatter_it_is_a_scene_dimmed_by_beer_and_lambert(small, model):
    direct = small.light.returns[0]
    dimmed = Return(direct.range_m, direct.strength * np.exp(-2 * 0.8 * direct.range_m))
    closed = ForwardModel(replace(small.light, returns=(dimmed,)), small.footprints, small.clock).expected(1e3)
    found = model.expected(1e3, [effect.at(extinction=0.8, albedo=0)])
    np.testing.assert_allclose(found, closed, atol=1e-4 * closed.max())


@pytest.mark.parametrize(("alpha", "overlap"), [(0.03, 0.05), (2.0, 0.2)])
def test_backscatter_is_the_integral_over_each_pixels_open_air(small, model, alpha, overlap):
    lit = model.expected(1e3, [effect.at(extinction=alpha, overlap=overlap)])
    air = (lit - model.expected(1e3, [effect.at(extinction=alpha, overlap=overlap, albedo=0)])).sum(axis=-1)
    ranges = small.light.range_m[0]
    layers = [quad(lambda r: np.exp(-2 * alpha * r) / (r**2 + overlap**2), 0, end)[0] for end in ranges.ravel()]
    weights = small.footprints.weights.reshape(4, -1)
    np.testing.assert_allclose(air[0], 1e3 * alpha / 4 * (weights @ np.array(layers)), rtol=2e-3)


def test_backscatter_does_not_come_from_behind_surfaces(small):
    near = direct_light(np.full((1, 6, 10), 0.2), small.light.intrinsics)
    fog = ForwardModel(near, small.footprints, small.clock)
    back = fog.expected(1e3, [effect.at()]) - fog.expected(1e3, [effect.at(albedo=0)])
    assert (back > -1e-9).all()
    # The pulse, placed where the farthest corner is, has all but its last share of a tail behind it.
    latest = small.clock.time_zero_s.max() + 2 * near.range_m.max() / 299_792_458
    end = int((latest + 3e-9) / small.clock.bin_width_s) + 1
    assert back[..., end:].max() < 1e-3 * back.max()


def test_surfaces_beyond_the_window_have_open_air_before_them(small):
    found = []
    for depth in (3.0, 50.0):
        far = direct_light(np.full((1, 6, 10), depth), small.light.intrinsics)
        found.append(ForwardModel(far, small.footprints, small.clock).expected(1e3, [effect.at()]))
    assert found[0].max() > 1
    np.testing.assert_allclose(found[0][..., :35], found[1][..., :35], atol=1e-6 * found[0].max())

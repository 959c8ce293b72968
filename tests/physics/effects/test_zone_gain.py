from types import SimpleNamespace

import numpy as np
import pytest

from physics.effects.cover_glass_crosstalk import effect as crosstalk
from physics.effects.zone_gain import _factors, effect
from physics.nominal import ForwardModel
from physics.rendering import Rendering

FACTORS = np.array([0, 0.5, 1, 3])


def test_each_zone_is_multiplied_and_its_background_is_not(small):
    model = ForwardModel(small.light, small.footprints, small.clock, 7.0)
    signal = model.expected(50.0) - 7
    np.testing.assert_allclose(
        model.expected(50.0, [effect.at(factor=FACTORS)]) - 7, signal * FACTORS[:, None], atol=1e-10
    )


def test_zones_that_became_less_sensitive_count_less_of_all_light(small):
    model = ForwardModel(small.light, small.footprints, small.clock, 7.0)
    found = model.expected(50.0, [effect.at(factor=FACTORS, ambient=1.0)])
    np.testing.assert_allclose(found, model.expected(50.0) * FACTORS[:, None], atol=1e-10)


def test_crosstalk_is_multiplied_too(small):
    model = ForwardModel(small.light, small.footprints, small.clock)
    both = model.expected(50.0, [effect.at(factor=FACTORS), crosstalk.at()])
    np.testing.assert_allclose(both, model.expected(50.0, [crosstalk.at()]) * FACTORS[:, None], atol=1e-10)


def test_one_zone_alone(small):
    model = ForwardModel(small.light, small.footprints, small.clock, 7.0)
    alone = model.expected(50.0, [effect.at(one=-0.4, zone=2)])
    np.testing.assert_allclose(alone, model.expected(50.0, [effect.at(factor=[1, 1, np.exp(-0.4), 1])]), rtol=1e-12)


@pytest.mark.parametrize(
    ("values", "logarithms"),
    [
        ({"across": 0.3}, [-0.3, 0.3, -0.3, 0.3]),
        ({"across": 0.1, "down": -0.5}, [0.4, 0.6, -0.6, -0.4]),
        ({"alternate": 0.2}, [0.2, -0.2, -0.2, 0.2]),
    ],
)
def test_over_the_grid_of_zones(small, values, logarithms):
    """Two rows of two zones, in row-major order."""
    model = ForwardModel(small.light, small.footprints, small.clock, 7.0)
    sloped = model.expected(50.0, [effect.at(**values)])
    np.testing.assert_allclose(sloped, model.expected(50.0, [effect.at(factor=np.exp(logarithms))]), rtol=1e-12)


def test_a_lens_that_shades_makes_the_corners_dim():
    """Three rows of five zones: the corners are √5 zones from the middle, others 1, √2, 2."""
    grid = Rendering(None, SimpleNamespace(zone_grid=(3, 5)), None, 1.0)
    found = np.log(_factors(effect.at(bow=-0.5).values, grid)).reshape(3, 5)
    np.testing.assert_allclose(found[1], [-0.4, -0.1, 0, -0.1, -0.4], atol=1e-12)
    np.testing.assert_allclose(found[[0, 2]], [[-0.5, -0.2, -0.1, -0.2, -0.5]] * 2, atol=1e-12)


def test_it_suggests_the_zone(small):
    model = ForwardModel(small.light, small.footprints, small.clock, 7.0)
    nominal = model.expected(1e3)
    excess = np.random.default_rng(2).poisson(model.expected(1e3, [effect.at(one=-0.2, zone=1)])) - nominal
    rendering = Rendering(small.light, small.footprints, small.clock, 1e3, background=7.0)
    assert [start["zone"] for start in effect.starts(excess, nominal, rendering)] == [1.0]

"""Fog against a sum over pixels and layers, and its limits."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from physics.effects.scattering_medium import effect
from physics.light import Return, direct_light
from physics.nominal import ForwardModel
from physics.rendering import Rendering


@pytest.fixture
def model(small):
    return ForwardModel(small.light, small.footprints, small.clock)


def test_without_backscatter_it_is_a_scene_dimmed_by_beer_and_lambert(small, model):
    direct = small.light.returns[0]
    dimmed = Return(direct.range_m, direct.strength * np.exp(-2 * 0.8 * direct.range_m))
    closed = ForwardModel(replace(small.light, returns=(dimmed,)), small.footprints, small.clock).expected(1e3)
    found = model.expected(1e3, [effect.at(extinction=0.8, albedo=0)])
    np.testing.assert_allclose(found, closed, atol=1e-4 * closed.max())


@pytest.mark.parametrize(("alpha", "overlap", "blind"), [(0.03, 0.05, 0.0), (2.0, 0.2, 0.0), (0.5, 0.1, 0.2)])
def test_backscatter_is_the_integral_over_each_pixels_open_air(small, model, alpha, overlap, blind):
    fog = {"extinction": alpha, "overlap": overlap, "blind": blind}
    air = (model.expected(1e3, [effect.at(**fog)]) - model.expected(1e3, [effect.at(**fog, albedo=0)])).sum(axis=-1)
    ranges = small.light.range_m[0]
    layers = [quad(lambda r: np.exp(-2 * alpha * r) / (r**2 + overlap**2), blind, end)[0] for end in ranges.ravel()]
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


def test_a_layer_dims_what_is_behind_it_and_lights_up_itself(small, model):
    alpha, overlap, begin, thickness = 1.5, 0.2, 0.4, 0.25
    layer = {"extinction": alpha, "overlap": overlap, "begin": begin, "thickness": thickness}
    dark = model.expected(1e3, [effect.at(**layer, albedo=0)])
    direct = small.light.returns[0]
    within = np.clip(direct.range_m - begin, 0, thickness)
    dimmed = Return(direct.range_m, direct.strength * np.exp(-2 * alpha * within))
    closed = ForwardModel(replace(small.light, returns=(dimmed,)), small.footprints, small.clock).expected(1e3)
    np.testing.assert_allclose(dark, closed, atol=1e-2 * closed.max())
    air = (model.expected(1e3, [effect.at(**layer)]) - dark).sum(axis=-1)
    ends = np.clip(small.light.range_m[0], begin, begin + thickness).ravel()
    layers = [quad(lambda r: np.exp(-2 * alpha * (r - begin)) / (r**2 + overlap**2), begin, end)[0] for end in ends]
    weights = small.footprints.weights.reshape(4, -1)
    np.testing.assert_allclose(air[0], 1e3 * alpha / 4 * (weights @ np.array(layers)), rtol=5e-3)


def test_each_zone_may_look_into_air_of_its_own(model):
    one, own = (model.expected(1e3, [effect.at(extinction=value)]) for value in (0.5, [0, 0.5, 0.2, 0.5]))
    np.testing.assert_allclose(own[:, [1, 3]], one[:, [1, 3]])
    np.testing.assert_allclose(own[:, 0], model.expected(1e3)[:, 0])


def test_it_suggests_where_a_layer_is(small):
    far = direct_light(np.full((3, 6, 10), 1.05), small.light.intrinsics, time_s=small.light.time_s)
    model = ForwardModel(far, small.footprints, small.clock, 2.0)
    nominal, gain = model.expected(3e4), 3e4
    foggy = model.expected(gain, [effect.at(extinction=0.2, begin=0.5, thickness=0.3)])
    excess = np.random.default_rng(1).poisson(foggy) - nominal
    rendering = Rendering(far, small.footprints, small.clock, gain, background=2.0)
    start, swathe, both = effect.starts(excess, nominal, rendering)
    assert abs(start["begin"] - 0.5) < 0.1
    assert abs(start["begin"] + start["thickness"] - 0.8) < 0.1
    assert both == start | swathe
    assert 5 * swathe["every"] == pytest.approx(np.ptp(far.time_s))
    assert effect.starts(np.zeros_like(nominal), nominal, rendering) == [swathe]


def test_swathes_that_drift_by_are_as_dense_as_it_is_then(small):
    """Each frame is as if the air were always as it is in it."""
    every = float(small.light.time_s[2]) / 2
    model = ForwardModel(small.light, small.footprints, small.clock)
    swathes = model.expected(1e3, [effect.at(haze_1=0.1, haze_2=0.9, haze_3=0.3, every=every)])
    for frame, density in enumerate((0.1, 0.9, 0.3)):
        always = model.expected(1e3, [effect.at(extinction=density)])
        np.testing.assert_allclose(swathes[frame], always[frame], rtol=1e-9)
    # Nobody says how long a session is.
    np.testing.assert_array_equal(model.expected(1e3, [effect.at(haze_1=0.5)]), model.expected(1e3))


@pytest.mark.parametrize(
    ("layer", "glass"),
    [
        ({"begin": 0.0, "thickness": 0.02}, True),
        ({"begin": 0.15, "thickness": 0.1}, False),
        ({"overlap": 0.3}, False),
        ({"overlap": 0.004}, True),
        ({"overlap": 0.004, "blind": 0.15}, False),
        ({"begin": 19.0, "thickness": 0.5}, False),
    ],
)
def test_air_that_shines_at_the_sensor_is_rather_its_glass(small, layer, glass):
    rendering = Rendering(small.light, small.footprints, small.clock, 1e3)
    assert effect.strained(effect.at(extinction=0.1, **layer).values, rendering) == glass
    # Half of ∫ dr / (r² + overlap²) from the blind range to the layer's end comes from nearer than its middle.
    values = effect.at(**layer).values
    begin, end = max(values["begin"], values["blind"]), values["begin"] + values["thickness"]
    inner, outer = (np.arctan(at / values["overlap"]) for at in (begin, end))
    assert (values["overlap"] * np.tan((inner + outer) / 2) < 0.1) == glass


def test_air_does_not_differ_much_from_zone_to_zone(small):
    rendering, dense = Rendering(small.light, small.footprints, small.clock, 1e3), [0.03, 0.04, 0.03, 0.035]
    assert not effect.strained(effect.at(extinction=np.array(dense), overlap=0.3).values, rendering)
    assert effect.strained(effect.at(extinction=np.array([*dense, 0.06]), overlap=0.3).values, rendering)
    assert not effect.strained(effect.at(extinction=0.0).values, rendering)


def test_smoke_grows_denser(small, model):
    """Each frame as in air that is as dense all the time as that is by then; air cannot be thinner than none."""
    for growth, densities in ((4.0, [0.5, 0.7, 0.9]), (-1.0, [0.5, 0.45, 0.4])):
        found = model.expected(1e3, [effect.at(extinction=0.5, growth=growth)])
        for i, density in enumerate(densities):
            np.testing.assert_allclose(found[i], model.expected(1e3, [effect.at(extinction=density)])[i], rtol=1e-9)
    later = replace(small.light, time_s=np.array([0.0, 1.0, 3.0]))
    gone = ForwardModel(later, small.footprints, small.clock).expected(1e3, [effect.at(extinction=0.5, growth=-1.0)])
    np.testing.assert_allclose(gone[1:], model.expected(1e3)[1:], rtol=1e-9)

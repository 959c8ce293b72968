"""Changed reflectance against scenes that are made of it, and hand-written factors of single pixels."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import physics.effects.reflectance_map as module
from physics.effects.reflectance_map import effect
from physics.light import direct_light
from physics.motion import Motion
from physics.nominal import ForwardModel

INTRINSICS = np.array([[8.0, 0, 4.5], [0, 8.0, 2.5], [0, 0, 1]])
SHAPE = (2, 6, 10)
NONE = {"contrast": 0.0, "step": 0.0, "spot": 0.0}
TEXTURE = {"slope_x": 0.7, "slope_y": -1.2, "bow_x": 0.9, "bow_y": -0.5, "bow_xy": 1.6}


def scene(reflectance):
    rng = np.random.default_rng(4)
    return direct_light(rng.uniform(0.3, 2, SHAPE), INTRINSICS, reflectance, rng.uniform(0.2, 1, SHAPE))


def seen(light, **values):
    return effect.light(effect.at(**(NONE | values)).values, SimpleNamespace(light=light))


@pytest.mark.parametrize("contrast", [-1.0, -0.4, 0.7, 2.0])
def test_contrast_is_a_scene_of_that_reflectance(contrast):
    assumed = np.random.default_rng(5).uniform(0.1, 0.5, SHAPE)
    found = seen(scene(assumed), contrast=contrast)
    closed = scene(0.5 * (assumed / 0.5) ** (1 + contrast))
    np.testing.assert_allclose(found.returns[0].strength, closed.returns[0].strength, rtol=1e-5)
    np.testing.assert_allclose(found.reflectance, closed.reflectance, rtol=1e-5)


def test_the_step_is_on_dark_surfaces_alone_and_its_edge_is_as_wide_as_documented():
    assumed = np.full(SHAPE, 0.9)
    assumed[:, :3] = 0.1
    assumed[0, 3] = 0.3
    assumed[0, 4] = 0.3 * np.exp(0.1)
    factor = seen(scene(assumed), step=np.log(4), level=0.3).reflectance / assumed
    np.testing.assert_allclose(factor[:, :3], 4, rtol=1e-3)
    np.testing.assert_allclose(factor[1, 3:], 1, rtol=1e-3)
    np.testing.assert_allclose(factor[0, 3], 2, rtol=1e-5)
    np.testing.assert_allclose(factor[0, 4], 4 ** (1 / (1 + np.e)), rtol=1e-5)


def test_the_spot_stays_in_the_field_of_view():
    light = scene(np.full(SHAPE, 0.4))
    found = seen(light, spot=-0.8, spot_x=0.2, spot_y=-0.1, spot_size=0.15)
    factor = found.returns[0].strength / light.returns[0].strength
    for v, u in ((0, 0), (2, 6), (5, 9)):
        x, y = (u - 4.5) / 8, (v - 2.5) / 8
        away = np.hypot(x - 0.2, y + 0.1) / 0.15
        closed = np.exp(-0.8 * np.exp(-(away**2) / 2))
        np.testing.assert_allclose(factor[:, v, u], closed, rtol=1e-5)


def test_the_texture_is_a_polynomial_of_the_tangents_the_same_in_all_frames():
    light = scene(np.full(SHAPE, 0.4))
    factor = seen(light, **TEXTURE).returns[0].strength / light.returns[0].strength
    for v, u in ((0, 0), (2, 6), (5, 9)):
        x, y = (u - 4.5) / 8, (v - 2.5) / 8
        terms = {"slope_x": x, "slope_y": y, "bow_x": x * x, "bow_y": y * y, "bow_xy": x * y}
        closed = np.exp(sum(TEXTURE[name] * term for name, term in terms.items()))
        np.testing.assert_allclose(factor[:, v, u], closed, rtol=1e-5)


def test_a_texture_of_the_world_stays_where_it_is_while_the_camera_moves():
    """A facing wall a metre off, seen from two places, the second beside the first and behind it."""
    depth = np.stack([np.full(SHAPE[1:], 1.0), np.full(SHAPE[1:], 1.5)])
    there = np.stack([np.eye(4), np.eye(4)])
    there[1, :3, 3] = 0.1, -0.05, -0.5
    light = direct_light(depth, INTRINSICS, None, time_s=[0.0, 0.1], motion=Motion(np.array([0, 0.1]), there))
    values = {"space_y": 0.3, "space_xx": 4.0, "space_xz": -7.0}
    factor = seen(light, **values).returns[0].strength / light.returns[0].strength
    for frame, (z, at) in enumerate(((1.0, (0, 0)), (1.5, (0.1, -0.05)))):
        for v, u in ((0, 0), (2, 6), (5, 9)):
            x, y = (u - 4.5) / 8 * z + at[0], (v - 2.5) / 8 * z + at[1]
            assert factor[frame, v, u] == pytest.approx(np.exp(0.3 * y + 4 * x**2 - 7 * x * 0.5), rel=1e-5)


def room():
    """3 frames of a wall and of a bar before it that moves; which pixels are the bar's."""
    u = np.broadcast_to(np.arange(40), (3, 30, 40))
    bar = np.abs(u - np.array([12, 16, 20])[:, None, None]) < 5
    intrinsics = np.array([[30.0, 0, 19.5], [0, 30.0, 14.5], [0, 0, 1]])
    return direct_light(np.where(bar, 0.8, 1.6), intrinsics, np.full(bar.shape, 0.5)), bar


def test_one_surface_or_each_has_its_own_factor_wherever_it_moves():
    light, bar = room()
    nominal = light.returns[0].strength
    alone = seen(light, one=0.4, surface=2).returns[0].strength / nominal
    np.testing.assert_allclose(alone, np.where(bar, np.exp(0.4), 1), rtol=1e-5)
    np.testing.assert_array_equal(seen(light, surface_2=0.4).returns[0].strength / nominal, alone)
    wall = seen(light, one=-0.4, surface=1).reflectance / light.reflectance
    np.testing.assert_allclose(wall, np.where(bar, 1, np.exp(-0.4)), rtol=1e-5)


def test_where_surfaces_are_told_apart_it_looks_at_all_frames():
    assert effect.reach(effect.at(one=0.3).values) == (np.inf, np.inf)
    assert effect.reach(effect.at(surface_4=0.3).values) == (np.inf, np.inf)
    assert effect.reach(effect.at(contrast=0.3, surface=3).values) == (0, 0)


def test_a_part_of_the_frames_knows_which_surface_is_which():
    light, bar = room()
    # In the last frame alone the bar is the larger: there it is surface 1, of all frames 2.
    depth = np.where(np.broadcast_to(np.arange(40) < 30, bar.shape), 0.8, 1.6)
    depth[:2] = np.where(bar[:2], 0.8, 1.6)
    intrinsics = light.intrinsics
    every = direct_light(depth, intrinsics, np.full(bar.shape, 0.5))
    some = every.of(np.array([1, 2])).of(np.array([1]))
    np.testing.assert_array_equal(some.surfaces, every.surfaces[2:])
    assert (direct_light(depth[2:], intrinsics).surfaces != some.surfaces).any()
    np.testing.assert_array_equal(
        seen(some, one=0.4, surface=2).reflectance, seen(every, one=0.4, surface=2).reflectance[2:]
    )


def test_where_no_reflectance_is_assumed_contrast_is_a_gain_and_the_step_nothing():
    plain = scene(None)
    np.testing.assert_allclose(
        seen(plain, contrast=0.6).returns[0].strength, 2**0.6 * plain.returns[0].strength, rtol=1e-6
    )
    np.testing.assert_allclose(seen(plain, step=-2).returns[0].strength, plain.returns[0].strength, rtol=1e-3)
    assert (seen(plain, spot=1, spot_size=3).returns[0].strength > 1.5 * plain.returns[0].strength).all()


def test_each_strength_acts_alone_and_together_they_multiply(small):
    model = ForwardModel(small.light, small.footprints, small.clock)
    one = {"contrast": 0.5, "step": -1.0, "spot": 0.7, **TEXTURE}
    for name, value in one.items():
        assert np.abs(model.expected(1e3, [effect.at(**(NONE | {name: value}))]) - model.expected(1e3)).max() > 10
    logs = [np.log(seen(small.light, **{name: value}).returns[0].strength) for name, value in one.items()]
    nominal = np.log(small.light.returns[0].strength)
    together = np.log(seen(small.light, **one).returns[0].strength)
    np.testing.assert_allclose(together - nominal, sum(log - nominal for log in logs), atol=1e-5)


def test_ranges_other_returns_and_frames_by_themselves_stay(small):
    second = replace(small.light.returns[0], strength=small.light.returns[0].strength / 3)
    both = replace(small.light, returns=(*small.light.returns, second))
    found = seen(both, contrast=1, spot=1)
    assert found.returns[1] is second
    assert found.range_m is small.light.range_m
    alone = replace(small.light, reflectance=small.light.reflectance[1:2], returns=(cut(small.light.returns[0]),))
    np.testing.assert_array_equal(seen(alone, contrast=1, spot=1).returns[0].strength[0], found.returns[0].strength[1])


def cut(way):
    return replace(way, range_m=way.range_m[1:2], strength=way.strength[1:2])


@given(
    contrast=st.floats(-1, 5),
    step=st.floats(-5, 5),
    spot=st.floats(-5, 5),
    dark=st.floats(0, 1, width=32),
)
def test_black_and_unknown_stay_dark_and_the_rest_is_finite(contrast, step, spot, dark):
    assumed = np.full(SHAPE, dark)
    assumed[0, 0, 0], assumed[0, 0, 1] = 0, np.nan
    found = seen(scene(assumed), contrast=contrast, step=step, spot=spot)
    strength = found.returns[0].strength
    assert np.isfinite(strength).all()
    assert (strength >= 0).all()
    assert (strength[0, 0, :2] == 0).all()
    assert np.isnan(found.reflectance[0, 0, 1])


def suggested(light):
    where = SimpleNamespace(weights=np.ones((1, *light.range_m.shape[1:])))
    rendering = SimpleNamespace(light=light, footprints=where, background=0.0)
    even = np.ones((light.frames, 1, 1))
    return effect.starts(0 * even, even, rendering)


def near_ranges(light):
    return [start["near_range"] for start in suggested(light) if "near" in start]


def test_small_surfaces_that_are_amiss_begin_beside_the_large_ones(monkeypatch):
    light = direct_light(np.where(np.arange(10) < 3, 1.0, 2.0) * np.ones(SHAPE), INTRINSICS)
    monkeypatch.setattr(module, "surfaces_amiss", lambda *_: [{"surface": 11.0, "told_by": 0.0}])
    assert [start["surface"] for start in suggested(light) if "one" in start] == [1, 2, 11]


@given(st.floats(0.3, 0.7), st.floats(1.3, 1.9))
def test_it_suggests_the_gap_between_an_object_and_the_wall_behind(near, far):
    rng = np.random.default_rng(6)
    depth = np.where(np.arange(10) < 3, near, far) * rng.uniform(0.98, 1.02, SHAPE)
    light = direct_light(depth, INTRINSICS)
    first = near_ranges(light)[0]
    assert (light.range_m[..., :3] < first).all()
    assert (light.range_m[..., 3:] > first).all()


def test_one_wall_has_no_gap():
    assert near_ranges(replace(scene(np.full(SHAPE, 0.5)), range_m=np.full(SHAPE, 1.0))) == []


def test_pixels_that_see_nothing_are_on_no_side_of_a_gap():
    light = direct_light(np.where(np.arange(10) < 5, 0.5, 1.5) * np.ones(SHAPE), INTRINSICS)
    holes = light.range_m.copy()
    holes[:, 0], holes[:, 1], holes[:, 2] = np.inf, np.nan, 0
    assert near_ranges(replace(light, range_m=holes)) == near_ranges(light) != []


@pytest.mark.parametrize(("values", "fixed"), [({"spot": 0.3}, True), ({"slope_x": 0.3}, True), ({"one": 0.3}, False)])
def test_what_stays_in_the_view_while_surfaces_pass_is_not_theirs(values, fixed):
    still = np.full((4, 5, 6), 0.8)
    nearing = still * (1 - 0.05 * np.arange(4))[:, None, None]
    nearing[0, 0, 0] = np.nan
    for ranges, passing in ((still, False), (nearing, True)):
        rendering = SimpleNamespace(light=SimpleNamespace(range_m=ranges))
        found = effect.at(**values).values
        assert (effect.contradiction(found, rendering) is not None) == (fixed and passing)

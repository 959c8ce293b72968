"""Materials told by their reflectance: scenes painted by hand, and by chance."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from physics.light import direct_light
from physics.materials import materials, parts
from physics.told_apart import BOTH, GEOMETRY, REFLECTANCE, numbers, surfaces_alone

SHAPE = (3, 40, 50)
INTRINSICS = np.array([[40.0, 0, 24.5], [0, 40.0, 19.5], [0, 0, 1]])
ONE_THING = np.ones(SHAPE, np.int32)
V, U = np.mgrid[: SHAPE[1], : SHAPE[2]]
LEFT = np.broadcast_to(U < 30, SHAPE)
TILES = np.broadcast_to((V // 4 + U // 4) % 2 == 0, SHAPE)


def test_what_is_painted_alike_is_one_material_wherever_it_is():
    bar = np.abs(U - np.array([12, 25, 38])[:, None, None]) < 4
    found = materials(np.where(bar, 0.7, 0.3).astype(np.float32), ONE_THING + bar)
    np.testing.assert_array_equal(found, np.where(bar, 2, 1))


@pytest.mark.parametrize("scatter", [0.05, 0.15])
def test_dyes_that_scatter_are_told_apart_where_few_pixels_lie_between(scatter):
    rng = np.random.default_rng(1)
    reflectance = np.where(LEFT, 0.15, 0.6) * np.exp(scatter * rng.normal(size=SHAPE))
    found = materials(reflectance.astype(np.float32), ONE_THING)
    assert (found == np.where(LEFT, 1, 2)).mean() > 0.97


def test_one_value_within_the_scatter_of_another_material_is_its_own():
    rng = np.random.default_rng(2)
    reflectance = np.where(LEFT, 0.3 * np.exp(0.2 * rng.normal(size=SHAPE)), 0.31).astype(np.float32)
    found = materials(reflectance, ONE_THING)
    np.testing.assert_array_equal(found, np.where(LEFT, 1, 2))


def test_tiles_are_one_material_and_two_things_beside_each_other_are_not():
    tiled = np.where(LEFT, np.where(TILES, 0.2, 0.6), 0.4).astype(np.float32)
    np.testing.assert_array_equal(materials(tiled, np.where(LEFT, 1, 2)), np.where(LEFT, 1, 2))
    plain = np.where(LEFT, 0.2, 0.4).astype(np.float32)
    np.testing.assert_array_equal(materials(plain, np.where(LEFT, 1, 2)), np.where(LEFT, 1, 2))


def test_grey_values_of_a_picture_are_no_materials_each():
    """Eight bits of a smooth shade: every value is frequent, none more than those about it."""
    shade = np.round(255 * (0.3 + 0.4 * U / 50)) / 255
    found = materials(np.broadcast_to(shade, SHAPE).astype(np.float32), ONE_THING)
    assert found.max() == 1


@given(st.floats(0.02, 1), st.floats(0, 1))
def test_unknown_and_black_are_none(level, part):
    reflectance = np.full(SHAPE, level, np.float32)
    reflectance[np.random.default_rng(3).random(SHAPE) < part] = np.nan
    reflectance[0, 0, 0] = 0
    found = materials(reflectance, ONE_THING)
    assert (found[np.nan_to_num(reflectance) == 0] == 0).all()
    assert (found[reflectance > 0] == 1).all()


def test_parts_are_of_one_surface_and_one_material():
    surface, material = np.where(V < 30, 1, 2), np.where(U < 30, 1, 2)
    np.testing.assert_array_equal(
        parts(surface, material), np.select([(V < 30) & (U < 30), V < 30, U < 30], [1, 2, 3], 4)
    )


def test_a_material_that_is_a_surface_is_looked_at_once():
    bar = np.broadcast_to(np.abs(U - 20) < 8, SHAPE)
    depth = np.where(bar, 0.8, 1.6)
    light = direct_light(depth, INTRINSICS, np.where(bar, 0.7, 0.3))
    assert surfaces_alone(light, 8) == [{"surface": k, "told_by": GEOMETRY} for k in (1, 2)]
    light = direct_light(depth, INTRINSICS, np.where(LEFT, 0.7, 0.3))
    assert surfaces_alone(light, 8)[2:] == [{"surface": k, "told_by": REFLECTANCE} for k in (1, 2)]
    for by, told in ((GEOMETRY, light.surfaces), (REFLECTANCE, light.materials), (BOTH, light.pieces)):
        np.testing.assert_array_equal(numbers({"told_by": by}, light), told)
    some = light.of(np.array([2, 0]))
    np.testing.assert_array_equal(some.materials, light.materials[[2, 0]])
    np.testing.assert_array_equal(some.pieces, light.pieces[[2, 0]])


def test_a_material_that_some_frames_do_not_show_is_none_of_theirs():
    """Most of a thing, seen but in the last frame, which shows the rest of it alone."""
    last = (np.arange(SHAPE[0]) == 2)[:, None, None]
    light = direct_light(np.full(SHAPE, 1.6), INTRINSICS, np.where(last, 0.7, 0.3))
    assert [one["told_by"] for one in surfaces_alone(light, 8)] == [GEOMETRY, REFLECTANCE, REFLECTANCE]
    assert surfaces_alone(light.of(np.array([2])), 8) == [{"surface": 1.0, "told_by": GEOMETRY}]

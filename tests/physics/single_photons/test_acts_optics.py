"""Acts of the optics, each by itself: where they vanish, and what is known of them in closed form."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.ndimage import map_coordinates

from physics.effects import all_effects, find_effect
from physics.single_photons.acts import find_act
from physics.single_photons.acts.footprint_blur import redrawn, sharpened, strayed
from physics.single_photons.looking import table
from physics.single_photons.sight import pixel_places, unit_response
from physics.single_photons.world import NO_PIXEL, Photons
from recordings.refusal import Refusal

PIXEL_PX = 84.8  # Columns of the grid, in pixels of the full-size image.
FOCAL = 7.5


@pytest.fixture
def world(both):
    return both().session.world(1)


def acted(world, name, **values):
    return find_act(name).world(world, find_effect(name).at(**values).values, np.random.default_rng(1))


def at_depth(world, depth_m, calibrated_m=None):
    """The world as a plane that faces the camera, maps taken at another depth."""
    meta = {} if calibrated_m is None else {"calibration_range_m": calibrated_m}
    return replace(
        world, depth_m=np.full_like(world.depth_m, depth_m), maps=replace(world.maps, meta_json=json.dumps(meta))
    )


@pytest.mark.parametrize("name", ["footprint_shift", "footprint_blur", "parallax"])
def test_where_an_act_vanishes_zones_look_where_they_did(name, world):
    gone = find_effect(name).vanished().values
    np.testing.assert_allclose(find_act(name).world(world, gone, None).weights, world.weights, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(("x", "y"), [(PIXEL_PX, 0), (-PIXEL_PX, 0), (0, 80), (PIXEL_PX, -80)])
def test_a_shift_by_a_pixel_rolls_the_weights(world, x, y):
    found = acted(world, "footprint_shift", x=x, y=y).weights
    rolled = np.roll(world.weights, (round(y / 80), round(x / PIXEL_PX)), axis=(1, 2))
    # What comes in from outside is not known, nor what was outside the scan; both are at the rim.
    np.testing.assert_allclose(found[:, 2:-2, 2:-2], rolled[:, 2:-2, 2:-2], rtol=1e-9)


def test_two_shifts_are_one_of_their_sum(world):
    twice = acted(acted(world, "footprint_shift", x=20, y=-7), "footprint_shift", x=11, y=30)
    np.testing.assert_allclose(twice.weights, acted(world, "footprint_shift", x=31, y=23).weights, atol=1e-12)


@pytest.mark.parametrize("variance", [0.5, 30, 900])
def test_a_blurred_point_has_the_variance_and_its_light(variance):
    x, y = np.arange(500), np.arange(400)
    point = np.zeros((1, 400, 500))
    point[0, 180, 260] = 1
    spread = strayed(point, variance)[0]
    assert spread.sum() == pytest.approx(1)
    assert spread.sum(axis=0) @ (x - 260) ** 2 == pytest.approx(variance, rel=1e-5)
    assert spread.sum(axis=1) @ (y - 180) ** 2 == pytest.approx(variance, rel=1e-5)
    corner = np.zeros((1, 400, 500))
    corner[0, 0, -1] = 1
    assert strayed(corner, variance).sum() == pytest.approx(1)


@given(st.floats(-9, 3), st.floats(-2, 2))
def test_walks_of_any_length_keep_all_light(log_variance, taller):
    """Whatever the variance: a search for where its tail ends had not come back for one of them."""
    point = np.zeros((1, 7, 9))
    point[0, 3, 4] = 1
    spread = strayed(point, 10**log_variance, taller)
    assert spread.sum() == pytest.approx(1, abs=1e-8)
    assert (spread >= 0).all()


def test_a_pixels_weight_is_what_photons_that_stray_find(world):
    """Photons displaced one by one, and the map looked up where each comes to be."""
    rng, variance, many = np.random.default_rng(4), 700.0, 100_000
    counts = table(world.maps)[2][0] / unit_response(world.maps, world.depth_m.shape)
    home_x, home_y = pixel_places(world.maps, world.depth_m.shape)
    found = acted(world, "footprint_blur", variance=variance).weights[0]
    for row, column in ((2, 3), (3, 6), (1, 5)):
        x, y = (home[row, column] + rng.normal(0, np.sqrt(variance), many) for home in (home_x, home_y))
        seen = map_coordinates(counts.astype(float), [y, x], order=1, mode="reflect")
        assert found[row, column] == pytest.approx(seen.mean(), abs=4 * seen.std() / np.sqrt(many) + 1e-5)


@pytest.mark.parametrize("taller", [0.0, 0.5])
def test_photons_that_stray_within_a_disc(world, taller):
    """Photons displaced evenly within an ellipse, one by one, and the map looked up where each comes to be."""
    rng, variance, many = np.random.default_rng(5), 700.0, 100_000
    counts = table(world.maps)[2][0] / unit_response(world.maps, world.depth_m.shape)
    home_x, home_y = pixel_places(world.maps, world.depth_m.shape)
    found = acted(world, "footprint_blur", variance=variance, taller=taller, flat=1.0).weights[0]
    far, turn = np.sqrt(rng.random(many)), rng.uniform(0, 2 * np.pi, many)
    half_x, half_y = 2 * np.sqrt(variance) * np.exp(np.array([-taller, taller]) / 2)
    for row, column in ((2, 3), (3, 6), (1, 5)):
        x, y = home_x[row, column] + half_x * far * np.cos(turn), home_y[row, column] + half_y * far * np.sin(turn)
        seen = map_coordinates(counts.astype(float), [y, x], order=1, mode="reflect")
        assert found[row, column] == pytest.approx(seen.mean(), abs=4 * seen.std() / np.sqrt(many) + 1e-4)


def test_a_sharper_map_keeps_its_sum_and_loses_the_variance():
    x, y = np.meshgrid(np.arange(-200.0, 201), np.arange(-150.0, 151))
    before = np.exp(-(x**2) / 2 / 40**2 - y**2 / 2 / 30**2)[None]
    after = sharpened(before, strayed(before, 100))
    assert (after >= 0).all()
    assert after.sum() == pytest.approx(before.sum())
    for along, variance in ((x, 40**2), (y, 30**2)):
        assert (after[0] * along**2).sum() / after.sum() == pytest.approx(variance - 100, rel=0.005)


@pytest.mark.parametrize("steeper", [-0.5, 0.5])
def test_a_power_of_a_map_keeps_its_light_and_the_places_that_see_nothing(world, steeper):
    _, _, counts = table(world.maps)
    assert (counts == 0).any()
    found = redrawn(world.maps, 0.0, steeper=steeper)
    np.testing.assert_array_equal(found == 0, counts == 0)
    np.testing.assert_allclose(found.sum(axis=(1, 2)), counts.sum(axis=(1, 2)))


@pytest.mark.parametrize("calibrated_m", [None, 2.4])
@pytest.mark.parametrize("columns", [1, -2])
def test_parallax_of_a_plane_is_its_disparity(world, calibrated_m, columns):
    """As far as the maps' plane is away, less at its depth: z = 0.6 m and as many columns as b·f·(1/z − 1/z_cal)."""
    plane = at_depth(world, 0.6, calibrated_m)
    nearer = 1 / 0.6 - (1 / calibrated_m if calibrated_m else 0)
    found = (
        find_act("parallax")
        .world(
            plane,
            {"x": columns / FOCAL / nearer, "y": 0.0, "ranges": 0.0, "whole": 0.0, "by_pixels": 0.0, "emitter": 0.0},
            None,
        )
        .weights
    )
    rolled = np.roll(world.weights, columns, axis=2)
    np.testing.assert_allclose(found[:, :, 3:-3], rolled[:, :, 3:-3], rtol=1e-6)


def test_parallax_moves_nothing_where_the_maps_were_taken_and_more_near_than_far(world):
    plane = at_depth(world, 0.7, 0.7)
    np.testing.assert_allclose(acted(plane, "parallax", x=0.1, y=-0.1).weights, world.weights, atol=1e-9)
    near, far = (acted(at_depth(world, z, 0.7), "parallax", x=0.02, y=0).weights - world.weights for z in (0.3, 0.6))
    assert np.abs(near).max() > 3 * np.abs(far).max() > 0


def test_parallax_leaves_pixels_of_unknown_depth_and_refuses_a_depth_that_is_none(world):
    holes = replace(world, depth_m=np.where(np.arange(10) < 5, np.nan, world.depth_m))
    np.testing.assert_array_equal(acted(holes, "parallax", x=0.05).weights[..., :5], world.weights[..., :5])
    with pytest.raises(Refusal, match="calibration_range_m is -1, expected metres above 0"):
        acted(at_depth(world, 0.5, -1), "parallax")


def of_every_zone(world, each=2000):
    zone = np.repeat(np.arange(world.zones, dtype=np.int32), each)
    return Photons(zone, world.time_zero_s[zone] + 1e-9, np.zeros(len(zone), np.int32), np.zeros(len(zone), np.int32))


def mirrored(world, photons, **values):
    return find_act("mirrored_zones").photons(
        photons, world, all_effects()["mirrored_zones"].vanished().values | values, np.random.default_rng(3)
    )


@pytest.mark.parametrize(
    ("values", "zones"),
    [
        ({}, [0, 1, 2, 3]),
        ({"rows": 1}, [2, 3, 0, 1]),
        ({"columns": 1}, [1, 0, 3, 2]),
        ({"transposed": 1}, [0, 2, 1, 3]),
        # First the row is mirrored, then row and column are exchanged.
        ({"rows": 1, "transposed": 1}, [1, 3, 0, 2]),
        ({"zones_exchanged": 1, "first": 1, "second": 3}, [0, 3, 2, 1]),
        ({"rows_exchanged": 1, "first": 0, "second": 1}, [2, 3, 0, 1]),
        # First the columns, then the mirrored rows.
        ({"columns_exchanged": 1, "first": 1, "second": 0, "rows": 1}, [3, 2, 1, 0]),
    ],
)
def test_photons_change_zones_and_clocks(world, values, zones):
    before = of_every_zone(world)
    after = mirrored(world, before, **values)
    np.testing.assert_array_equal(after.zone, np.array(zones)[before.zone])
    np.testing.assert_allclose(after.time_s - world.time_zero_s[after.zone], 1e-9, rtol=1e-9)
    along = mirrored(world, before, clocks=1, **values)
    np.testing.assert_array_equal(along.time_s, before.time_s)


def test_of_a_part_of_the_photons_each_choice_is_its_own(world):
    after = mirrored(world, of_every_zone(world, 40_000), rows=0.3, columns=0.2)
    found = np.bincount(after.zone[:40_000], minlength=4) / 40_000
    np.testing.assert_allclose(found, [0.7 * 0.8, 0.7 * 0.2, 0.3 * 0.8, 0.3 * 0.2], atol=0.01)


def test_photons_from_no_pixel_stay(world):
    inside = replace(of_every_zone(world), pixel=np.full(8000, NO_PIXEL, np.int32))
    np.testing.assert_array_equal(mirrored(world, inside, rows=1, columns=1, transposed=1).zone, inside.zone)


def test_a_grid_that_is_not_square_is_counted_down_its_columns(world):
    wide = replace(world, zone_grid=(2, 3), time_zero_s=np.arange(6) * 1e-9)
    zone = np.arange(6, dtype=np.int32)
    before = Photons(zone, wide.time_zero_s + 5e-9, np.zeros(6, np.int32), np.zeros(6, np.int32))
    after = mirrored(wide, before, transposed=1)
    # Rows of three, 0 1 2 and 3 4 5, are counted 0 2 4 and 1 3 5 down the columns.
    np.testing.assert_array_equal(after.zone, [0, 2, 4, 1, 3, 5])
    np.testing.assert_allclose(after.time_s - wide.time_zero_s[after.zone], 5e-9, rtol=1e-9)

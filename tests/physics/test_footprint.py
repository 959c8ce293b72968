"""Footprints against scipy's griddata, and what moves and changes them."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.interpolate import griddata
from scipy.ndimage import shift
from scipy.spatial import ConvexHull, Delaunay

from physics.footprint import FootprintField, footprints
from recordings.maps import ResponseMaps
from recordings.refusal import Refusal


@pytest.fixture
def faint(maps):
    """Maps that have fallen to nothing well before the scan ends."""
    off = np.maximum(np.abs(maps.xs - 420) / 380, np.abs(maps.ys - 240) / 210)
    return replace(maps, responses=maps.responses * (off < 0.7))


def test_maps_are_read_as_griddata_does_and_divided_by_one_number(maps):
    found = footprints(maps, (60, 106)).weights
    v, u = np.mgrid[:60, :106]
    at = ((u + 0.5) * 8 - 0.5, (v + 0.5) * 8 - 0.5)
    read = np.stack([griddata((maps.xs, maps.ys), zone, at, fill_value=0) for zone in maps.by_zone])
    np.testing.assert_allclose(found, read / read.max(), atol=1e-12)
    assert found.max() == 1
    assert found[:, 0].max() == 0  # Above the hull of the scan.


def test_a_full_size_image_of_another_size(maps):
    half = replace(maps, xs=maps.xs / 2, ys=maps.ys / 2, meta_json=json.dumps({"image_size": [424, 240]}))
    # Half the pixels, whose centres are at half the places less a quarter.
    shifted = replace(half, xs=half.xs - 0.25, ys=half.ys - 0.25)
    np.testing.assert_allclose(footprints(shifted, (12, 20)).weights, footprints(maps, (12, 20)).weights, atol=1e-9)


def inside(maps, x, y):
    """Where points are in the hull of the scan, by scipy's own triangles."""
    return Delaunay(np.stack([maps.xs, maps.ys], axis=1)).find_simplex(np.stack([x, y], axis=-1)) >= 0


@pytest.mark.parametrize(("x", "y"), [(848 / 80, 0), (-3 * 848 / 80, 20), (0.3, -71.7)])
def test_moved_footprints_are_griddata_of_a_moved_scan(maps, x, y):
    still = footprints(maps, (48, 80))
    moved = still.moved(x, y).weights
    at = (still.x_px, still.y_px)
    read = np.stack([griddata((maps.xs + x, maps.ys + y), zone, at, fill_value=0) for zone in maps.by_zone])
    # Where neither place is beyond the scan, where maps fade.
    sure = inside(maps, *at) & inside(maps, still.x_px - x, still.y_px - y)
    np.testing.assert_allclose(moved[:, sure], read[:, sure] / still.scale, atol=1e-9)


def test_a_move_by_whole_pixels_rolls_weights(faint):
    still = footprints(faint, (48, 80))
    rolled = np.roll(still.weights, (3, -2), axis=(2, 1))
    moved = still.moved(3 * 848 / 80, -20).weights
    np.testing.assert_allclose(moved, rolled, atol=1e-6)
    far = np.stack([still.x_px * 0, still.x_px * 0 + 3 * 848 / 80])
    by_frame = still.moved(far, np.array([0, -20.0])[:, None, None]).weights
    np.testing.assert_allclose(by_frame, [still.weights, rolled], atol=1e-6)


@pytest.mark.parametrize("stride", [1, 2])
def test_weights_of_pixels_may_move_as_images_do(maps, stride):
    """Against scipy's bilinear shift of each zone's weights, with nothing outside; by halves of both by halves."""
    whole = footprints(maps, (30, 40))
    home = whole.read_at(whole.x_px[::stride, ::stride], whole.y_px[::stride, ::stride])
    step = home.x_px[0, 1] - home.x_px[0, 0], home.y_px[1, 0] - home.y_px[0, 0]
    moved = home.moved(1.3 * step[0], -0.6 * step[1], by_pixels=1.0).weights
    wanted = [shift(zone, (-0.6, 1.3), order=1, mode="grid-constant") for zone in home.weights]
    np.testing.assert_allclose(moved, wanted, atol=1e-9)
    half, anew = (home.moved(1.3 * step[0], -0.6 * step[1], by_pixels=of).weights for of in (0.5, 0.0))
    np.testing.assert_allclose(half, (moved + anew) / 2, atol=1e-9)


def test_a_move_by_nothing_is_none(maps):
    still = footprints(maps, (12, 20))
    np.testing.assert_array_equal(still.moved(0, 0).weights, still.weights)
    np.testing.assert_array_equal(still.moved(7, -3).moved(-7, 3).weights, still.weights)


@settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(x=st.floats(-150, 150), y=st.floats(-150, 150))
def test_moves_are_continuous_though_the_scan_ends(maps, x, y):
    still = footprints(maps, (12, 20))
    change = still.moved(x + 1e-4, y - 1e-4).weights - still.moved(x, y).weights
    # Within a reach of 54 px from full to nothing, and a few times steeper between two scan points.
    assert np.abs(change).max() < 10 * 1e-4 / still.field.reach_px
    assert still.moved(x, y).weights.min() >= 0


def test_beyond_the_scan_the_nearest_response_fades(maps):
    field = FootprintField(maps)
    hull = ConvexHull(np.stack([maps.xs, maps.ys], axis=1))
    edge = np.concatenate([np.linspace(*hull.points[pair], 4000) for pair in hull.simplices])
    x, y = np.random.default_rng(3).uniform((-100, -100), (950, 580), (300, 2)).T
    x, y = (a[~inside(maps, x, y)] for a in (x, y))
    distance = np.hypot(x[:, None] - edge[:, 0], y[:, None] - edge[:, 1])
    nearest = hull.points.mean(axis=0) + (edge[distance.argmin(axis=1)] - hull.points.mean(axis=0)) * (1 - 1e-9)
    left = np.clip(1 - distance.min(axis=1) / field.reach_px, 0, None)
    assert 0 < (left > 0).sum() < len(left)
    np.testing.assert_allclose(field.faded(x, y), field(*nearest.T) * left, atol=1e-3 * maps.responses.max())


def test_the_table_holds_image_and_scan(maps):
    beside = replace(maps, xs=maps.xs + 200)
    field = FootprintField(beside)
    assert field.first == (0, 0)
    assert field.table.shape == (4, 480, np.ceil(beside.xs.max()) + 1)
    assert beside.xs.max() > 848
    x, y = np.array([300, 901, 0]), np.array([200, 333, 479])
    np.testing.assert_allclose(field.table[:, y, x], field.faded(x, y), rtol=1e-6, atol=1e-6)


def test_what_drawings_add_is_kept_for_one_grid_alone(faint):
    still = footprints(faint, (48, 80))
    part = still.read_at(still.x_px[5:9], still.y_px[5:9])

    def twice(table):
        return 2 * table

    whole = still.redrawn(twice).weights
    np.testing.assert_array_equal(still.redrawn(twice).weights, whole)
    np.testing.assert_array_equal(part.redrawn(twice).weights, whole[:, 5:9])


def test_one_zone_is_read_as_it_is_with_all(maps):
    field, rng = footprints(maps, (6, 8)).field, np.random.default_rng(4)
    x, y = rng.uniform(-20, 900, 500), rng.uniform(-20, 520, 500)
    every = field.faded(x, y)
    for zone in range(len(every)):
        np.testing.assert_allclose(field.faded(x, y, zone), every[zone : zone + 1], rtol=1e-12, atol=1e-9)


def test_drawings_add_where_footprints_have_moved(faint):
    still = footprints(faint, (480, 848))
    twice = still.redrawn(lambda table: 2 * table)
    np.testing.assert_allclose(twice.weights, 2 * still.weights, atol=1e-6)
    np.testing.assert_allclose(twice.moved(30, 7).weights, 2 * still.moved(30, 7).weights, atol=1e-6)
    np.testing.assert_array_equal(still.redrawn(lambda table: table).weights, still.weights)
    assert still.redrawn(lambda table: -table).weights.max() < 1e-6


def test_the_depth_of_the_scan_is_that_of_the_maps_else_as_given(maps):
    said = replace(maps, meta_json=json.dumps({"calibration_range_m": 0.4}))
    assert footprints(said, (6, 10), 0.7).calibration_range_m == 0.4
    assert footprints(maps, (6, 10), 0.7).calibration_range_m == 0.7
    assert footprints(maps, (6, 10)).calibration_range_m == np.inf
    for bad in ("near", True, 0, -1.0, float("nan")):
        with pytest.raises(Refusal, match=r"calibration_range_m is .*, expected metres above 0"):
            footprints(maps, (6, 10), bad)


def test_changes_apply_in_order_and_survive_a_move(maps):
    still = footprints(maps, (12, 20))
    twice = still.changed(lambda w: 2 * w).changed(lambda w: w + 1)
    np.testing.assert_allclose(twice.weights, 2 * still.weights + 1)
    np.testing.assert_allclose(twice.moved(50, 0).weights, 2 * still.moved(50, 0).weights + 1)


def test_only_pixels_that_some_zone_sees_are_kept(maps):
    made = footprints(maps, (60, 106))
    ((pixels, weights),) = made.seen
    assert len(pixels) < 60 * 106
    back = np.zeros((4, 60 * 106), np.float32)
    back[:, pixels] = weights.T
    np.testing.assert_array_equal(back, made.weights.reshape(4, -1).astype(np.float32))


def test_maps_that_show_nothing_are_refused(maps):
    with pytest.raises(Refusal, match="no response above 0"):
        footprints(replace(maps, responses=np.zeros_like(maps.responses)), (6, 10))
    line = ResponseMaps(np.ones((1, 1, 3)), np.arange(3.0), np.arange(3.0), np.array(["a", "b", "c"]))
    with pytest.raises(Refusal, match="span no triangle"):
        FootprintField(line)

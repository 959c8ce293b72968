import json
from dataclasses import replace

import numpy as np
import pytest

from fusion.sight import sight
from physics.effects import find_effect
from physics.footprint import footprints
from physics.light import direct_light
from physics.rendering import Rendering
from recordings.refusal import Refusal

INTRINSICS = np.array([[30.0, 0, 15.5], [0, 30, 11.5], [0, 0, 1]])


def mount(x, y):
    """LiDAR at x, y in the camera's frame, turned a little."""
    turn = np.array([[np.cos(0.2), -np.sin(0.2), 0], [np.sin(0.2), np.cos(0.2), 0], [0, 0, 1]])
    made = np.eye(4)
    made[:3, :3], made[:3, 3] = turn, -turn @ np.array([x, y, 0.0])
    return made


def test_weights_are_those_of_the_forward_model(rig):
    np.testing.assert_allclose(rig.sight.weights, footprints(rig.maps, (24, 32)).weights, rtol=1e-6)
    np.testing.assert_allclose(rig.sight.normalised.max(axis=(1, 2)), 1)
    v, u = 5, 20
    ray = np.array([(u - 15.5) / 30, (v - 11.5) / 30, 1])
    assert rig.sight.ray_length[v, u] == pytest.approx(np.linalg.norm(ray))
    np.testing.assert_allclose(rig.sight.rays[v, u], ray, rtol=1e-6)


def test_spans_hold_all_that_is_heard(rig):
    for p, row in ((0, 2), (1, 11), (3, 20)):
        first, last = rig.sight.spans[p, row]
        outside = np.delete(rig.sight.heard[p, row], slice(first, last))
        assert not outside.any()
        assert last == first or (rig.sight.heard[p, row, [first, last - 1]] > 0).all()


def test_the_coarse_grid_keeps_light_and_directions(rig):
    fine = sight(rig.maps, (120, 160), np.diag([5, 5, 1.0]) @ INTRINSICS)
    coarse = fine.coarse
    assert coarse.shape == (60, 80)
    np.testing.assert_allclose(coarse.weights[2, 30, 41], fine.weights[2, 60:62, 82:84].mean(), rtol=1e-5)
    np.testing.assert_allclose(coarse.rays[7, 20], fine.rays[14:16, 40:42].mean(axis=(0, 1)), atol=1e-6)


@pytest.mark.parametrize(("shape", "expected"), [((480, 848), (60, 106)), ((60, 106), (45, 80)), ((24, 32), (24, 32))])
def test_the_coarse_grid_is_never_too_coarse(rig, shape, expected):
    assert sight(rig.maps, shape, INTRINSICS).coarse.shape == expected


@pytest.mark.parametrize("depth", [0.3, 0.8, 2.0])
def test_parallax_is_where_rays_from_the_lidar_meet_the_plane_of_the_scan(rig, depth):
    place, cal = np.array([0.02, -0.03, 0]), 0.8
    there = sight(rig.maps, (24, 32), INTRINSICS, mount(*place[:2]))
    shift = there.shift_px(depth * there.stretch)
    # The point seen at this pixel; the LiDAR's ray to it; where that met the plane of the scan; its pixel.
    pixel = np.array([18.0, 9.0])
    point = depth * np.array([(pixel[0] - 15.5) / 30, (pixel[1] - 11.5) / 30, 1])
    met = place + (point - place) * cal / depth
    in_map = 30 * met[:2] / met[2] + INTRINSICS[:2, 2]
    np.testing.assert_allclose(shift, np.tile(pixel - in_map, (4, 1)), atol=1e-6)


def test_zones_that_report_nothing_are_not_moved(rig):
    there = sight(rig.maps, (24, 32), INTRINSICS, mount(0.02, 0))
    assert not there.shift_px(np.full(4, np.nan)).any()


def test_a_moved_sight_has_its_footprints_elsewhere(rig):
    there = sight(rig.maps, (24, 32), INTRINSICS, mount(0.1, 0))
    # 30 px · 0.1 m · (1/z − 1/0.8) = 3 px.
    moved = there.moved(there.stretch / (1 + 1 / 0.8))
    np.testing.assert_allclose(moved.weights[:, :, 3:], there.weights[:, :, :-3], atol=1e-6)
    np.testing.assert_allclose(moved.coarse.weights, moved.weights, rtol=1e-5)
    assert rig.sight.moved(np.full(4, 1.0)) is rig.sight


@pytest.mark.parametrize("depth", [0.4, 2.5])
def test_moved_footprints_are_those_that_the_forward_model_sees(rig, depth):
    """A wall at a depth, through `physics.effects.parallax`, against footprints displaced as a whole."""
    wall = direct_light(np.full((1, 120, 160), depth, np.float32), np.diag([5, 5, 1.0]) @ INTRINSICS)
    nominal = footprints(rig.maps, (120, 160))
    true = find_effect("parallax").at(x=0.03, y=-0.02)
    seen = true.effect.apply("footprints", true.values, Rendering(wall, nominal, None, 1.0)).weights[0]
    there = sight(rig.maps, (120, 160), np.diag([5, 5, 1.0]) @ INTRINSICS, mount(0.03, -0.02))
    # Beyond the image, whence some of the maps come at its edge, nothing is kept.
    inside = (slice(None), slice(8, -8), slice(8, -8))
    np.testing.assert_allclose(there.moved(depth * there.stretch).weights[inside], seen[inside], atol=0.02)
    assert np.abs(there.weights - seen)[inside].max() > 0.1


def test_effects_on_footprints_are_those_of_the_forward_model(rig):
    shift = find_effect("footprint_shift").at(x=6.0, y=-4.0)
    aside = find_effect("parallax").at(x=0.01, y=0.0)
    moved = sight(rig.maps, (24, 32), INTRINSICS, effects=(shift, aside, find_effect("pile_up").at()))
    # 6 px of 64 are 3 of 32.
    np.testing.assert_allclose(moved.weights[:, 6:20, 8:28], rig.sight.weights[:, 8:22, 5:25], atol=0.02)
    np.testing.assert_allclose(moved.baseline_m, [0.01, 0, 0])


def test_the_maps_say_where_the_lidar_is(rig):
    meta = rig.maps.meta | {"lidar_from_camera": mount(0.01, 0.02).tolist()}
    there = sight(replace(rig.maps, meta_json=json.dumps(meta)), (24, 32), INTRINSICS)
    np.testing.assert_allclose(there.baseline_m, [0.01, 0.02, 0], atol=1e-12)


def test_what_does_not_fit_is_refused(rig):
    far = replace(rig.maps, meta_json='{"image_size": [2, 2]}', xs=rig.maps.xs + 100)
    with pytest.raises(Refusal, match="no scan point lies in their 2 x 2 image"):
        sight(far, (24, 32), INTRINSICS)
    with pytest.raises(Refusal, match="lidar_from_camera has shape"):
        sight(rig.maps, (24, 32), INTRINSICS, np.eye(3))
    with pytest.raises(Refusal, match="camera grid"):
        sight(rig.maps, (0, 32), INTRINSICS)


def test_a_mount_that_slips_is_where_it_was_at_the_beginning(rig):
    slipping, shifted = (
        sight(rig.maps, (24, 32), INTRINSICS, effects=(find_effect("footprint_shift").at(x=6.0, **more),))
        for more in ({"slip_x": 5.0}, {})
    )
    np.testing.assert_array_equal(slipping.weights, shifted.weights)

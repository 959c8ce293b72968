"""Parallax against points in space: rays from the LiDAR through them, to the plane of the scan, into the image."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.interpolate import RegularGridInterpolator, griddata
from scipy.linalg import expm
from scipy.spatial import Delaunay

from physics.effects.footprint_shift import effect as shift
from physics.effects.parallax import effect
from physics.light import direct_light
from physics.nominal import ForwardModel
from physics.rendering import Rendering

from ..conftest import slow_model


def seen_in_the_scan(light, depth_m, baseline, calibration_range_m):
    """(F, H, W, 2) full-size pixels at which the scan saw the rays from the LiDAR to the points of each pixel."""
    fx, fy, cx, cy = (light.intrinsics[i] for i in ((0, 0), (1, 1), (0, 2), (1, 2)))
    out = np.empty((*depth_m.shape, 2))
    lidar = np.array([*baseline, 0.0])
    for (f, v, u), z in np.ndenumerate(depth_m):
        point = z * np.array([(u - cx) / fx, (v - cy) / fy, 1])
        along = (point - lidar) / np.linalg.norm(point - lidar)
        met = lidar + along * calibration_range_m / along[2]
        x, y = fx * met[0] / met[2] + cx, fy * met[1] / met[2] + cy
        out[f, v, u] = (x + 0.5) * 848 / 10 - 0.5, (y + 0.5) * 480 / 6 - 0.5
    return out


@pytest.fixture
def depth_m(small):
    return small.light.range_m / np.linalg.norm(small.light.rays, axis=-1)


def moved(small, x, y, calibration_range_m):
    where = replace(small.footprints, calibration_range_m=calibration_range_m)
    return effect.footprints(effect.at(x=x, y=y).values, Rendering(small.light, where, small.clock, 1.0))


@pytest.mark.parametrize(("x", "y"), [(0.01, 0.0), (0.0, -0.05), (-0.03, 0.1)])
@pytest.mark.parametrize("calibration_range_m", [0.4, 2.0, 1e9])
def test_pixels_are_weighed_where_the_scan_saw_their_rays(small, depth_m, x, y, calibration_range_m):
    found = moved(small, x, y, calibration_range_m)
    wanted = seen_in_the_scan(small.light, depth_m.astype(float), (x, y), calibration_range_m)
    np.testing.assert_allclose(np.stack([found.x_px, found.y_px], axis=-1), wanted, atol=1e-3)


def test_maps_may_move_as_a_whole(small, depth_m):
    """By a shift in each frame, that of a plane where the zones on average see the inverse of depth."""
    where = replace(small.footprints, calibration_range_m=0.7)
    rendering = Rendering(small.light, where, small.clock, 1.0)
    found = effect.footprints(effect.at(x=0.03, y=-0.02, whole=1).values, rendering)
    seen = where.weights.sum(axis=0)
    for f, depth in enumerate(depth_m.astype(float)):
        nearer = np.average(1 / depth, weights=seen) - 1 / 0.7
        one = shift.footprints(
            shift.at(
                x=0.03 * small.light.intrinsics[0, 0] * 84.8 * nearer,
                y=-0.02 * small.light.intrinsics[1, 1] * 80 * nearer,
            ).values,
            rendering,
        )
        np.testing.assert_allclose(found.x_px[f], one.x_px, atol=1e-3)
        np.testing.assert_allclose(found.y_px[f], one.y_px, atol=1e-3)


@pytest.mark.parametrize(("x", "y", "ranges"), [(0.05, 0.0, 1.0), (-0.03, 0.08, 1.0), (0.04, 0.04, 0.5)])
def test_ways_may_be_from_the_lidar_too(small, depth_m, x, y, ranges):
    light, lidar = small.light, ranges * np.array([x, y, 0.0])
    moved_light = effect.light(
        effect.at(x=x, y=y, ranges=ranges).values, Rendering(light, small.footprints, small.clock, 1)
    )
    found, before = moved_light.returns[0], light.returns[0]
    fx, fy, cx, cy = (light.intrinsics[i] for i in ((0, 0), (1, 1), (0, 2), (1, 2)))
    for (f, v, u), z in np.ndenumerate(depth_m):
        way = np.linalg.norm(float(z) * np.array([(u - cx) / fx, (v - cy) / fy, 1]) - lidar)
        assert found.range_m[f, v, u] == pytest.approx(way, rel=1e-5)
        nearer = (before.range_m[f, v, u] / way) ** 2
        assert found.strength[f, v, u] == pytest.approx(before.strength[f, v, u] * nearer, rel=1e-5)
    assert effect.light(effect.at(x=x, y=y).values, Rendering(light, small.footprints, small.clock, 1)) is light


def test_counts_of_every_frame_are_those_of_its_own_weights(small, maps, depth_m):
    at = seen_in_the_scan(small.light, depth_m.astype(float), (0.02, -0.01), 0.6)
    read = np.stack([griddata((maps.xs, maps.ys), zone, at, fill_value=0) for zone in maps.by_zone], axis=1)
    # Pixels that leave or enter the scan are another test's: here they are dark.
    hull = Delaunay(np.stack([maps.xs, maps.ys], axis=1))
    here = np.stack([small.footprints.x_px, small.footprints.y_px], axis=-1)
    sure = (hull.find_simplex(at) >= 0) & (hull.find_simplex(here) >= 0)
    direct = small.light.returns[0]
    light = replace(small.light, returns=(replace(direct, strength=direct.strength * sure),))
    where = replace(small.footprints, calibration_range_m=0.6)
    found = ForwardModel(light, where, small.clock).expected(1.0, [effect.at(x=0.02, y=-0.01)])
    clock = small.clock
    for f in range(3):
        one = replace(
            light,
            range_m=light.range_m[f : f + 1],
            returns=(
                replace(
                    light.returns[0], range_m=direct.range_m[f : f + 1], strength=light.returns[0].strength[f : f + 1]
                ),
            ),
        )
        weights = read[f] / where.scale
        wanted = slow_model(one, weights, clock.bin_width_s, clock.bins, clock.time_zero_s, clock.pulse)
        np.testing.assert_allclose(found[f : f + 1], wanted, atol=2e-4 * wanted.max())


def test_in_the_plane_of_the_scan_nothing_moves(small):
    wall = direct_light(np.full((1, 6, 10), 0.6), small.light.intrinsics)
    model = ForwardModel(wall, replace(small.footprints, calibration_range_m=0.6), small.clock)
    np.testing.assert_allclose(model.expected(1e3, [effect.at(x=0.1, y=0.1)]), model.expected(1e3), rtol=1e-4)


@settings(deadline=None, max_examples=20, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(x=st.floats(-0.03, 0.03), y=st.floats(-0.03, 0.03), depth=st.floats(0.3, 2.0))
def test_before_a_wall_it_is_a_shift_that_goes_with_disparity(small, x, y, depth):
    wall = direct_light(np.full((1, 6, 10), depth), small.light.intrinsics)
    model = ForwardModel(wall, replace(small.footprints, calibration_range_m=1.0), small.clock)
    by = [7.5 * size * b * (1 / depth - 1) for size, b in ((84.8, x), (80, y))]
    wanted = model.expected(1e3, [shift.at(x=by[0], y=by[1])])
    found = model.expected(1e3, [effect.at(x=x, y=y)])
    np.testing.assert_allclose(found, wanted, atol=1e-4 * wanted.max())


def test_pixels_of_unknown_depth_stay_and_the_nearest_leave(small):
    depth = np.full((1, 6, 10), 1.0)
    depth[0, 2, 3], depth[0, 3, 4], depth[0, 4, 5] = np.nan, 0.0, 1e-6
    light = direct_light(depth, small.light.intrinsics, cosine=np.ones((1, 6, 10)))
    found = effect.footprints(effect.at(x=0.05, y=0.0).values, Rendering(light, small.footprints, small.clock, 1.0))
    np.testing.assert_array_equal(found.weights[0, :, [2, 3], [3, 4]], small.footprints.weights[:, [2, 3], [3, 4]].T)
    assert not found.weights[0, :, 4, 5].any()


@pytest.mark.parametrize(("x", "y"), [(0.02, -0.01), (-0.04, 0.03)])
def test_the_emitter_may_be_beside_the_camera_alone(small, depth_m, x, y):
    """Zones see where they saw, and each point is lit as that which the emitter lit so in the scan."""
    where = replace(small.footprints, calibration_range_m=0.8)
    rendering = Rendering(small.light, where, small.clock, 1.0)
    setting = effect.at(x=x, y=y, emitter=1)
    assert effect.footprints(setting.values, rendering) is where
    found = effect.light(setting.values, rendering).returns[0].strength / small.light.returns[0].strength
    rows, columns = np.indices((6, 10))
    spread = []
    for zone in where.weights:
        right, down = np.average(columns, weights=zone), np.average(rows, weights=zone)
        spread.append(np.average((columns - right) ** 2 + (rows - down) ** 2, weights=zone) / 2)
    variance = np.average(spread, weights=where.weights.sum(axis=(1, 2))) / 4
    # Diffusion along each axis, by its differential equation, no flux through the edges.
    profile = where.weights.sum(axis=0)
    for axis, size in enumerate(profile.shape):
        second = np.diff(np.eye(size), axis=0)
        flow = expm(-variance / 2 * second.T @ second)
        profile = np.moveaxis(np.tensordot(flow, profile, (1, axis)), 0, axis)
    profile = np.maximum(profile, 0.03 * profile.max())
    reads = RegularGridInterpolator((np.arange(6), np.arange(10)), profile)
    at = seen_in_the_scan(small.light, depth_m.astype(float), (x, y), 0.8)
    places = np.stack([(at[..., 1] + 0.5) / 80 - 0.5, (at[..., 0] + 0.5) / 84.8 - 0.5], axis=-1)
    np.testing.assert_allclose(found, reads(places.clip(0, (5, 9))) / profile, rtol=1e-3)


def test_an_emitter_that_nothing_moves_lights_as_it_did(small):
    wall = direct_light(np.full((1, 6, 10), 0.6), small.light.intrinsics)
    model = ForwardModel(wall, replace(small.footprints, calibration_range_m=0.6), small.clock)
    np.testing.assert_allclose(
        model.expected(1e3, [effect.at(x=0.1, y=0.1, emitter=1)]), model.expected(1e3), rtol=1e-4
    )

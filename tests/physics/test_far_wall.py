"""A wall far ahead against rays cast at a mesh of it by Open3D."""

from dataclasses import replace

import numpy as np
import open3d as o3d
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from physics.far_wall import met, normal_of, planes, seen_through, toward_unknown, walls
from physics.light import direct_light
from physics.motion import Motion
from physics.nominal import ForwardModel
from physics.rendering import Rendering

INTRINSICS = np.array([[8.0, 0, 4.5], [0, 8.0, 2.5], [0, 0, 1]])
HOLE = np.arange(10) > 5
angles = st.floats(-0.6, 0.6)
tilts = st.floats(-0.4, 0.4)


def session(poses=None, frames=3):
    """A wall at 0.5 m in whose right part nothing is known."""
    depth, times = np.where(HOLE, np.nan, 0.5) * np.ones((frames, 6, 10)), 0.1 * np.arange(frames)
    return direct_light(depth, INTRINSICS, time_s=times, motion=Motion.of(times, poses))


def cast(light, camera, depth, azimuth, elevation, tilt):
    """Ranges and cosines of incidence on a large square."""
    looks = Rotation.from_euler("YX", [azimuth, elevation])
    x, y = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]).T * 0.95 * depth
    corners = looks.apply(np.stack([x, y, depth - tilt[0] * x - tilt[1] * y], axis=1)).astype(np.float32)
    mesh = o3d.t.geometry.RaycastingScene()
    mesh.add_triangles(corners, np.array([[0, 1, 2], [0, 2, 3]], np.uint32))
    rays = light.rays / np.linalg.norm(light.rays, axis=-1, keepdims=True)
    ways = np.concatenate([np.broadcast_to(camera[:3, 3], rays.shape), rays @ camera[:3, :3].T], axis=-1)
    hit = mesh.cast_rays(o3d.core.Tensor(ways.astype(np.float32)))
    normals = hit["primitive_normals"].numpy()
    return hit["t_hit"].numpy(), np.abs((normals * ways[..., 3:]).sum(axis=-1))


@settings(max_examples=30, deadline=None)
@given(angles, angles, st.tuples(tilts, tilts), st.tuples(angles, angles, angles), st.booleans())
def test_a_wall_is_where_rays_meet_it(azimuth, elevation, tilt, turn, still):
    poses = np.tile(np.eye(4), (3, 1, 1))
    poses[:, :3, :3] = Rotation.from_rotvec(np.outer([0, 0.5, 1], turn)).as_matrix()
    poses[:, :3, 3] = np.outer([0, 1, 2], [0.3, -0.2, 0.4])
    light, normal = session(poses), normal_of((azimuth, elevation), tilt)
    where = planes(normal, np.full(3, 9.0), light.motion if still else None, light.time_s)
    (way,) = seen_through(light, *where)
    for i in range(3):
        ranges, cosines = cast(light, poses[i] if still else np.eye(4), 9.0, azimuth, elevation, tilt)
        there = HOLE & np.isfinite(ranges) & (cosines > 0.06)
        np.testing.assert_allclose(way.range_m[i][there], ranges[there], rtol=1e-4)
        np.testing.assert_allclose(way.strength[i][there], (cosines / ranges**2)[there], rtol=1e-3)
    assert not way.strength[:, :, ~HOLE].any()


def test_what_is_known_or_behind_shows_no_wall():
    light = session()
    behind = planes(normal_of((np.pi, 0.0)), np.full(3, 9.0), None, light.time_s)
    (way,) = seen_through(light, *behind)
    assert not way.strength.any()
    known = direct_light(np.full((3, 6, 10), 0.5), INTRINSICS, time_s=light.time_s)
    assert seen_through(known, *behind) == []
    ahead = planes(normal_of((0.0, 0.0)), np.full(3, 9.0), None, light.time_s)
    (way,) = seen_through(known, *ahead, anywhere=True)
    for found, wanted in zip((way.range_m, way.strength), met(light.rays, *ahead), strict=True):
        np.testing.assert_allclose(found, wanted, rtol=1e-6)
    assert toward_unknown(known, None) == (0.0, 0.0)


@pytest.mark.parametrize(("turn", "still"), [(0.0, 0.0), (1.2, 1.0)])
def test_it_is_found_across_where_depth_is_unknown(small, turn, still):
    """One that stands still is told from one that goes along by a camera that turns."""
    poses = np.tile(np.eye(4), (12, 1, 1))
    poses[:, :3, :3] = Rotation.from_rotvec(np.outer(np.linspace(0, turn, 12), [0, 1, 0])).as_matrix()
    light = session(poses, 12)
    toward = toward_unknown(light, light.motion if still else None)
    assert toward[0] == pytest.approx(np.arctan2(3.5, 8) + turn / 2, abs=0.1)
    normal = normal_of(toward)
    where = planes(normal, np.full(12, 8.95), light.motion if still else None, light.time_s)
    (way,) = seen_through(light, *where)
    clock = small.clock
    model, early_m = ForwardModel(light, small.footprints, clock, 4.0), np.float32(299_792_458 / 2 * 5.6e-8)
    early = replace(way, range_m=np.maximum(way.range_m - early_m, 0))
    there = ForwardModel(replace(light, returns=(early,)), small.footprints, clock, 0.0).expected(3e5)
    nominal = model.expected(1e6)
    excess = np.random.default_rng(3).poisson(nominal + there) - nominal
    found = walls(excess, nominal, Rendering(light, small.footprints, clock, 1e6, background=4.0), 5.6e-8, [2e-10])
    assert [one["still"] for one in found] == ([0.0, 1.0] if still else [0.0])
    assert abs(found[-1]["depth"] - 8.95) < 0.06
    assert found[-1]["azimuth"] == pytest.approx(toward[0])

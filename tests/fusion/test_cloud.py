"""Points against Open3D's own, and clouds of zones alone."""

import hypothesis.extra.numpy as some_arrays
import hypothesis.strategies as st
import numpy as np
import open3d as o3d
import pytest
from hypothesis import given, settings

from fusion.cloud import cloud, zone_cloud
from fusion.depths import zone_depths
from fusion.fused import FusedFrame

INTRINSICS = np.array([[70.0, 0, 31.5], [0, 75, 22.0], [0, 0, 1]])


def frame(depth, rgb=None, pose=None, sigma=None):
    depth = np.asarray(depth, np.float32)
    sigma = np.full(depth.shape, 0.01, np.float32) if sigma is None else sigma
    trust, zones = np.ones(depth.shape, np.float32), np.arange(depth.size, dtype=np.uint8).reshape(depth.shape)
    return FusedFrame(1.5, depth, sigma, trust, zones, rgb, INTRINSICS, pose, "splat")


def test_points_and_colours_are_those_of_open3d():
    rng = np.random.default_rng(0)
    depth = rng.permutation(np.linspace(0.3, 4, 150 * 64)).reshape(150, 64).astype(np.float32)
    depth[rng.random(depth.shape) < 0.3] = np.nan
    rgb = rng.integers(0, 256, (*depth.shape, 3), np.uint8)
    made = cloud(frame(depth, rgb)).open3d()
    tensor = o3d.core.Tensor.from_numpy
    images = o3d.t.geometry.Image(tensor(rgb)), o3d.t.geometry.Image(tensor(np.nan_to_num(depth)[..., None]))
    theirs = o3d.t.geometry.PointCloud.create_from_rgbd_image(
        o3d.t.geometry.RGBDImage(*images), tensor(INTRINSICS), depth_scale=1.0, depth_max=10.0
    )
    found, expected = (
        np.hstack([one.point.positions.numpy(), one.point.colors.numpy() / scale])
        for one, scale in ((made, 255.0), (theirs, 1.0))
    )
    # Its threads put points in any order; depth is one of its kind.
    found, expected = (points[np.argsort(points[:, 2], kind="stable")] for points in (found, expected))
    np.testing.assert_allclose(found, expected, atol=1e-5)


@settings(max_examples=30, deadline=None)
@given(
    some_arrays.arrays(
        np.float32,
        st.tuples(st.integers(1, 130), st.integers(1, 7)),
        elements=st.sampled_from([np.nan, np.inf, -1, 0, 0.5, 2]),
    ),
    st.floats(0, 1),
)
def test_a_point_for_every_pixel_that_is_known_well_enough(depth, bound):
    sigma = np.where(np.arange(depth.size).reshape(depth.shape) % 2, 0.5, np.nan).astype(np.float32)
    made = cloud(frame(depth, sigma=sigma), most_sigma_m=bound)
    kept = np.isin(depth, (0.5, 2)) & ~(sigma > np.float32(bound))
    assert len(made) == kept.sum()
    np.testing.assert_array_equal(made.points_m[:, 2], depth[kept])
    np.testing.assert_array_equal(made.zones, np.arange(depth.size, dtype=np.uint8).reshape(depth.shape)[kept])
    assert made.colours is None


def test_a_pose_takes_points_to_the_world():
    pose = np.eye(4)
    pose[:3] = [[0, 0, 1, 1.0], [-1, 0, 0, 2.0], [0, -1, 0, 3.0]]
    made = cloud(frame(np.full((45, 64), 2.0)))
    moved = made.in_world(pose)
    expected = np.stack([made.points_m[:, 2] + 1, 2 - made.points_m[:, 0], 3 - made.points_m[:, 1]], axis=1)
    np.testing.assert_allclose(moved.points_m, expected, atol=1e-6)
    np.testing.assert_array_equal(moved.pose, pose)
    assert made.pose is None


def test_it_writes_a_coloured_ply(tmp_path):
    rgb = np.full((45, 64, 3), (255, 128, 0), np.uint8)
    o3d.t.io.write_point_cloud(str(tmp_path / "a.ply"), cloud(frame(np.full((45, 64), 2.0), rgb)).open3d())
    found = o3d.io.read_point_cloud(str(tmp_path / "a.ply"))
    assert len(found.points) == 45 * 64
    assert np.asarray(found.colors)[0] == pytest.approx([1, 128 / 255, 0], abs=1e-3)


def test_zones_alone_give_a_point_in_their_direction(rig):
    """Bells at known places of the image, a surface at 1.2 m: the point lies on the bell's ray."""
    at = np.abs(rig.response.range_m - 1.2).argmin()
    counts = np.round(2000 * rig.response.counts[:, at] + 3)
    counts[2] = 0  # dead
    made = zone_cloud(rig.sight, zone_depths(counts, rig.response), 7.0)
    assert made.zones.tolist() == [0, 1, 3]
    assert made.timestamp_s == 7.0
    assert np.linalg.norm(made.points_m, axis=1) == pytest.approx(rig.response.range_m[at], abs=0.02)
    for point, (x, y) in zip(made.points_m, [(20, 14), (44, 14), (44, 34)], strict=True):
        pixel = INTRINSICS_OF_RIG @ (point / point[2])
        # The full-size image is twice as fine; bells are cut by the image's edge, so their middle is not exact.
        assert pixel[:2] == pytest.approx([(x + 0.5) / 2 - 0.5, (y + 0.5) / 2 - 0.5], abs=0.5)


INTRINSICS_OF_RIG = np.array([[30.0, 0, 15.5], [0, 30, 11.5], [0, 0, 1]])

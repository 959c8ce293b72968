"""The weighted volume against Open3D's own where weights are equal, and against a weighted mean where they are not."""

import numpy as np
import open3d as o3d
import pytest

from fusion.fused import FusedFrame
from fusion.volume import Volume
from recordings.refusal import Refusal

INTRINSICS = np.array([[80.0, 0, 39.5], [0, 80, 29.5], [0, 0, 1]])
SHAPE = (60, 80)


def wall(depth_m, sigma_m=0.02, pose=None, colour=100):
    depth = np.full(SHAPE, depth_m, np.float32)
    sigma, trust = np.full(SHAPE, sigma_m, np.float32), np.ones(SHAPE, np.float32)
    rgb = np.full((*SHAPE, 3), colour, np.uint8)
    pose = np.eye(4) if pose is None else pose
    return FusedFrame(0.0, depth, sigma, trust, np.zeros(SHAPE, np.uint8), rgb, INTRINSICS, pose, "splat")


def at_x(x_m):
    pose = np.eye(4)
    pose[0, 3] = x_m
    return pose


def test_equal_weights_are_open3d_s_own_integration():
    v, u = np.mgrid[: SHAPE[0], : SHAPE[1]]
    bumpy = (1.2 + 0.1 * np.sin(u / 9) + 0.05 * np.cos(v / 7)).astype(np.float32)
    one, ours = wall(1.0, sigma_m=1.0), Volume(voxel_m=0.03)
    theirs = o3d.t.geometry.VoxelBlockGrid(
        ("tsdf", "weight", "color"), (o3d.core.float32,) * 3, ((1,), (1,), (3,)), 0.03, 8, 5000
    )
    # It takes the pixel at the whole part of a place, which is the nearest for centres at halves.
    halves = np.add(INTRINSICS, [[0, 0, 0.5], [0, 0, 0.5], [0, 0, 0]])
    for shift in (0.0, 0.02):
        ours.add(FusedFrame(0.0, bumpy, one.sigma_m, one.confidence, one.zones, None, INTRINSICS, at_x(shift), "splat"))
        depth = o3d.t.geometry.Image(o3d.core.Tensor.from_numpy(bumpy[..., None].copy()))
        extrinsic = o3d.core.Tensor(np.linalg.inv(at_x(shift)))
        blocks = theirs.compute_unique_block_coordinates(depth, o3d.core.Tensor(INTRINSICS), extrinsic, 1.0, 10.0, 4.0)
        theirs.integrate(blocks, depth, o3d.core.Tensor(halves), extrinsic, 1.0, 10.0, 4.0)
    fields = []
    for grid in (theirs, ours.grid):
        places, found = grid.hashmap().find(blocks)
        assert found.numpy().all()
        fields.append([grid.attribute(name).numpy()[places.numpy()] for name in ("tsdf", "weight")])
    (tsdf, weight), (our_tsdf, our_weight) = fields
    # Where a voxel falls between two pixels, rounding decides.
    same = (weight == our_weight).mean(), (np.abs(tsdf - our_tsdf) < 1e-3)[weight > 0].mean()
    assert min(same) > 0.95
    assert (weight == 2).mean() > 0.2


def test_a_surface_lies_at_the_weighted_mean():
    volume = Volume(voxel_m=0.04)
    volume.add(wall(1.00, 0.01, colour=200))
    volume.add(wall(1.05, 0.02, colour=100))
    weight = 1 / np.array([0.01, 0.02]) ** 2
    mesh = volume.mesh()
    z = mesh.vertex.positions.numpy()[:, 2]
    assert np.median(z) == pytest.approx(np.average([1.00, 1.05], weights=weight), abs=0.001)
    colours = mesh.vertex.colors.numpy()
    assert np.median(colours) * 255 == pytest.approx(np.average([200, 100], weights=weight), abs=2)


def test_what_is_not_known_well_enough_is_left_out():
    volume = Volume()
    volume.add(wall(1.01, 0.1))
    assert len(volume.cloud(most_sigma_m=0.11).point.positions) > 0
    assert len(volume.cloud(most_sigma_m=0.08).point.positions) == 0
    volume.add(wall(1.01, 0.1))  # Two of 0.1 are one of 0.07.
    assert len(volume.cloud(most_sigma_m=0.08).point.positions) > 0


def test_a_long_way_is_bounded_and_the_oldest_goes():
    volume = Volume(voxel_m=0.04, most_blocks=150)
    for x in np.arange(0, 20, 0.25):
        volume.add(wall(1.01, pose=at_x(x)))
        assert volume.grid.hashmap().size() <= 150
    assert volume.grid.hashmap().capacity() <= 2 * 150
    assert volume.dropped_blocks > 100
    x = volume.cloud().point.positions.numpy()[:, 0]
    assert x.max() > 19.7
    assert x.min() > 10


def test_a_block_that_was_dropped_begins_anew():
    volume = Volume(voxel_m=0.04, most_blocks=60)
    for x in (0, 30, 60, 90, 120):
        volume.add(wall(1.0, 0.001, pose=at_x(x)))
    volume.add(wall(1.06, 0.1, pose=at_x(0)))
    found = volume.cloud().point.positions.numpy()
    here = np.abs(found[:, 0]) < 1
    assert np.median(found[here, 2]) == pytest.approx(1.06, abs=0.003)


def test_nothing_is_added_where_nothing_is_known():
    assert Volume().add(wall(np.nan)) == 0
    assert Volume().add(wall(50.0)) == 0
    assert Volume().add(wall(1.0, np.nan)) == 0


@pytest.mark.parametrize(
    ("act", "said"),
    [
        (lambda: Volume(voxel_m=0), "voxel_m is 0, expected finite metres above 0"),
        (lambda: Volume(most_blocks=0), "most_blocks is 0"),
        (lambda: Volume().mesh(), "the volume is empty"),
        (lambda: Volume(most_blocks=3).add(wall(2.0)), "blocks of 0.32 m, expected 3 at most"),
        (lambda: Volume().add(wall(1.0), np.full((4, 4), np.nan)), "expected finite"),
    ],
)
def test_refusals(act, said):
    with pytest.raises(Refusal, match=said):
        act()


def test_a_frame_without_pose_is_refused():
    one = wall(1.0)
    bare = FusedFrame(0.0, one.depth_m, one.sigma_m, one.confidence, one.zones, None, INTRINSICS, None, "splat")
    with pytest.raises(Refusal, match="no pose"):
        Volume().add(bare)

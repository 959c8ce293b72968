"""Many frames in one volume: a truncated signed distance field whose weights are those of every pixel."""

import threading
from typing import TYPE_CHECKING

import numpy as np
from numba import njit

from fusion.fused import FusedFrame
from physics.workers import in_parallel
from recordings.refusal import Refusal

if TYPE_CHECKING:
    import open3d

# Voxels along an edge of a block, and along the truncation on either side of a surface.
EDGE = 8
TRUNCATION = 4
TASKS = 8


class Volume:
    """A signed distance field in an Open3D `VoxelBlockGrid`, which weighs every pixel of a frame alike; here a pixel
    weighs 1/σ², so that a voxel known by frames of independent errors has standard error 1/√weight (Curless & Levoy,
    A volumetric method for building complex models from range images, 1996, §3: the optimal weights).

    voxel_m: edge of a voxel. most_blocks: how many blocks of 8³ voxels, 10 kB each, it holds at most: beyond, those
    that were seen the longest ago make room. farthest_m: depth beyond it is left out. frames: how many were added.
    dropped_blocks: how many have made room. grid: the `VoxelBlockGrid`, for whatever else Open3D can do.
    """

    def __init__(self, voxel_m: float = 0.04, most_blocks: int = 20_000, farthest_m: float = 10.0) -> None:
        import open3d.core as core
        from open3d.t.geometry import VoxelBlockGrid

        for name, value, unit in (("voxel_m", voxel_m, "metres"), ("farthest_m", farthest_m, "metres")):
            if not (np.isfinite(value) and value > 0):
                raise Refusal(f"{name} is {value}, expected finite {unit} above 0")
        if most_blocks < 1:
            raise Refusal(f"most_blocks is {most_blocks}, expected 1 or more")
        self.voxel_m, self.most_blocks, self.farthest_m = float(voxel_m), int(most_blocks), float(farthest_m)
        self.frames = self.dropped_blocks = 0
        self._one_at_a_time = threading.Lock()  # A mesh may be wanted by another thread than adds frames.
        channels = ((1,), (1,), (3,))
        device, kinds = core.Device("CPU:0"), (core.float32,) * 3
        names = ("tsdf", "weight", "color")  # What Open3D's extraction looks for.
        self.grid = VoxelBlockGrid(names, kinds, channels, self.voxel_m, EDGE, self.most_blocks, device)
        # The frame in which each block was seen last, by its place in the buffer.
        self._last = np.zeros(self.grid.hashmap().capacity(), np.int64)

    def add(self, frame: FusedFrame, pose: np.ndarray | None = None) -> int:
        """Add a frame; how many blocks it touched. pose: (4, 4) world from camera, that of the frame where None."""
        pose = frame.pose if pose is None else pose
        if pose is None:
            raise Refusal("the frame has no pose, expected world from camera, recorded or by odometry")
        pose = np.asarray(pose, float)
        if pose.shape != (4, 4) or not np.isfinite(pose).all():
            raise Refusal(f"pose has shape {pose.shape}, expected finite (4, 4)")
        good = (frame.depth_m > 0) & (frame.depth_m < self.farthest_m) & (frame.sigma_m > 0)
        if not good.any():
            return 0
        depth = np.where(good, frame.depth_m, 0).astype(np.float32)
        # A standard error below a millionth of a voxel is none that a sensor has, and would be infinite weight.
        weights = np.where(good, 1 / np.maximum(frame.sigma_m, 1e-6 * self.voxel_m) ** 2, 0).astype(np.float32)
        with self._one_at_a_time:
            return self._added(frame, depth, weights, pose)

    def _added(self, frame: FusedFrame, depth: np.ndarray, weights: np.ndarray, pose: np.ndarray) -> int:
        """How many blocks were touched by depth (H, W) metres, 0 where unknown, of weights (H, W)."""
        keys, places = self._blocks(depth, np.asarray(frame.intrinsics, float), np.linalg.inv(pose))
        rgb = np.empty((0, 0, 3), np.uint8) if frame.rgb is None else np.ascontiguousarray(frame.rgb, np.uint8)
        fields = [self.grid.attribute(name).numpy() for name in ("tsdf", "weight", "color")]
        matrix = np.asarray(frame.intrinsics, float) @ np.linalg.inv(pose)[:3]
        rest = depth, weights, rgb, matrix, self.voxel_m, self.voxel_m * TRUNCATION
        parts = np.array_split(np.arange(len(places)), min(TASKS, len(places)))
        in_parallel(lambda part: _integrate(keys[part], places[part], *fields, *rest), parts)
        self.frames += 1
        self._last[places] = self.frames
        return len(places)

    def mesh(self, most_sigma_m: float = np.inf) -> "open3d.t.geometry.TriangleMesh":
        """The surface as triangles, where the standard error of all eight voxels around it is `most_sigma_m` or less.

        Errors of frames are taken to be independent, which those of one still scene are not.
        """
        with self._one_at_a_time:
            return self.grid.extract_triangle_mesh(self._least_weight(most_sigma_m))

    def cloud(self, most_sigma_m: float = np.inf) -> "open3d.t.geometry.PointCloud":
        """The surface as points with colours and normals, by the same rule."""
        with self._one_at_a_time:
            return self.grid.extract_point_cloud(self._least_weight(most_sigma_m))

    def _least_weight(self, most_sigma_m: float) -> float:
        """The weight of this standard error; a little above 0 for none, as blocks hold voxels that nothing touched."""
        if self.grid.hashmap().size() == 0:
            raise Refusal("the volume is empty, expected at least one frame with depth")
        return max(1 / most_sigma_m**2, 1e-9)

    def _blocks(self, depth: np.ndarray, intrinsics: np.ndarray, extrinsic: np.ndarray) -> tuple[np.ndarray, ...]:
        """Keys (N, 3) and places in the buffer (N,) of the blocks around the surfaces of a frame; new ones are made."""
        import open3d.core as core
        from open3d.t.geometry import Image

        tensor = core.Tensor.from_numpy
        seen = self.grid.compute_unique_block_coordinates(
            Image(tensor(np.ascontiguousarray(depth[..., None]))),
            tensor(np.ascontiguousarray(intrinsics)),
            tensor(np.ascontiguousarray(extrinsic)),
            1.0,
            self.farthest_m,
            float(TRUNCATION),
        )
        if len(seen) > self.most_blocks:
            raise Refusal(
                f"a frame sees {len(seen)} blocks of {EDGE * self.voxel_m:g} m, expected {self.most_blocks} "
                "at most: larger voxels, or more blocks"
            )
        blocks = self.grid.hashmap()
        _, known = blocks.find(seen)
        fresh = seen[known.logical_not()]
        if len(fresh):
            self._make_room(len(fresh), seen[known])
            blocks.activate(fresh)
            places, _ = blocks.find(fresh)
            for name in ("tsdf", "weight", "color"):  # What an earlier block has left there.
                self.grid.attribute(name).numpy()[places.numpy()] = 0
        places, _ = blocks.find(seen)
        return seen.numpy(), places.numpy().astype(np.int64)

    def _make_room(self, wanted: int, kept: "open3d.core.Tensor") -> None:
        """Erase the blocks seen the longest ago, as many as are needed for so many new ones; never those of `kept`."""
        import open3d.core as core

        blocks = self.grid.hashmap()
        excess = blocks.size() + wanted - self.most_blocks
        if excess <= 0:
            return
        active = blocks.active_buf_indices().numpy().astype(np.int64)
        here = blocks.find(kept)[0].numpy().astype(np.int64) if len(kept) else []  # Open3D wants keys to look for.
        ages = np.where(np.isin(active, here), self.frames + 1, self._last[active])
        # Whole quarters at a time: that a few more are gone costs less than to look for room in every frame.
        number = min(max(excess, self.most_blocks // 4), int((ages <= self.frames).sum()))
        oldest = active[np.argsort(ages, kind="stable")[:number]]
        blocks.erase(core.Tensor.from_numpy(blocks.key_tensor().numpy()[oldest].copy()))
        self.dropped_blocks += number


@njit(nogil=True, cache=True)
def _integrate(keys, places, tsdf, weight, colour, depth, weights, rgb, matrix, voxel, truncation):
    """Running weighted means in the voxels of some blocks; matrix (3, 4): image from world, depth in the third row."""
    height, width = depth.shape
    for b in range(len(places)):
        place = places[b]
        for k in range(EDGE):
            for j in range(EDGE):
                for i in range(EDGE):
                    x = (keys[b, 0] * EDGE + i) * voxel
                    y = (keys[b, 1] * EDGE + j) * voxel
                    z = (keys[b, 2] * EDGE + k) * voxel
                    far = matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2] * z + matrix[2, 3]
                    if far <= 0:
                        continue
                    u = (matrix[0, 0] * x + matrix[0, 1] * y + matrix[0, 2] * z + matrix[0, 3]) / far + 0.5
                    v = (matrix[1, 0] * x + matrix[1, 1] * y + matrix[1, 2] * z + matrix[1, 3]) / far + 0.5
                    if not (0 <= u < width and 0 <= v < height):
                        continue
                    column, row = int(u), int(v)
                    added, distance = weights[row, column], depth[row, column] - far
                    if not added > 0 or distance < -truncation:
                        continue
                    before = weight[place, k, j, i, 0]
                    share = added / (before + added)
                    value = min(distance / truncation, 1.0)
                    tsdf[place, k, j, i, 0] += share * (value - tsdf[place, k, j, i, 0])
                    if rgb.size:
                        for c in range(3):
                            now = colour[place, k, j, i, c]
                            colour[place, k, j, i, c] = now + share * (rgb[row, column, c] - now)
                    weight[place, k, j, i, 0] = before + added

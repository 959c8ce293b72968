"""A fused frame becomes a coloured point cloud."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numba import njit

from fusion.fused import FusedFrame
from fusion.sight import Sight
from fusion.zone_view import ZoneDepths
from physics.geometry import inverse_pinhole
from physics.workers import in_parallel

if TYPE_CHECKING:
    import open3d

# Rows that one task turns into points.
BLOCK_ROWS = 60


@dataclass(frozen=True, eq=False)
class Cloud:
    """N points with what is known of them.

    points_m: (N, 3) float32 metres.
    sigma_m: (N,) float32 standard error of each point's depth. confidence: (N,) float32 0 to 1, how much of it the
    sensor rather than the prior says. zones: (N,) uint8, the zone that contributes most. colours: (N, 3) uint8, None
    where there was no image. timestamp_s: seconds. pose: (4, 4) that took the points to the world, None where they are
    in the camera's frame.
    """

    points_m: np.ndarray
    sigma_m: np.ndarray
    confidence: np.ndarray
    zones: np.ndarray
    colours: np.ndarray | None
    timestamp_s: float
    pose: np.ndarray | None = None

    def __len__(self) -> int:
        return len(self.points_m)

    def in_world(self, pose: np.ndarray) -> "Cloud":
        """The cloud in the world's frame: pose (4, 4) is world from camera."""
        turn, shift = (np.asarray(part, np.float32) for part in (pose[:3, :3], pose[:3, 3]))
        return replace(self, points_m=self.points_m @ turn.T + shift, pose=pose)

    def open3d(self) -> "open3d.t.geometry.PointCloud":
        """The cloud for Open3D, sharing memory with this one: positions, colors, sigma and confidence."""
        import open3d

        shared = open3d.core.Tensor.from_numpy
        cloud = open3d.t.geometry.PointCloud(shared(self.points_m))
        if self.colours is not None:
            cloud.point.colors = shared(self.colours)
        cloud.point.sigma, cloud.point.confidence = shared(self.sigma_m[:, None]), shared(self.confidence[:, None])
        return cloud


def cloud(frame: FusedFrame, most_sigma_m: float = np.inf, least_confidence: float = 0.0) -> Cloud:
    """The points of a frame, in the camera's frame, row by row.

    Left out are pixels without depth, with a standard error above `most_sigma_m` metres, or below `least_confidence`.
    """
    depth = np.ascontiguousarray(frame.depth_m, np.float32)
    images = {
        "sigma_m": np.ascontiguousarray(frame.sigma_m, np.float32),
        "confidence": np.ascontiguousarray(frame.confidence, np.float32),
        "zones": np.ascontiguousarray(frame.zones, np.uint8),
    }
    rgb = None if frame.rgb is None else np.ascontiguousarray(frame.rgb, np.uint8)
    inverse = inverse_pinhole(frame.intrinsics)
    blocks = [slice(at, min(at + BLOCK_ROWS, len(depth))) for at in range(0, len(depth), BLOCK_ROWS)]
    bounds = np.float32(most_sigma_m), np.float32(least_confidence)
    held = in_parallel(lambda b: _count(depth[b], images["sigma_m"][b], images["confidence"][b], *bounds), blocks)
    ends = np.cumsum(held)
    points = np.empty((ends[-1], 3), np.float32)
    sigma, confidence = np.empty(ends[-1], np.float32), np.empty(ends[-1], np.float32)
    zones, colours = np.empty(ends[-1], np.uint8), np.empty((ends[-1] if rgb is not None else 0, 3), np.uint8)
    colour = np.empty((0, 0, 3), np.uint8) if rgb is None else rgb

    def one(i: int) -> None:
        b, out = blocks[i], slice(ends[i] - held[i], ends[i])
        source = depth[b], *(image[b] for image in images.values()), colour[b]
        _fill(inverse, b.start, *source, *bounds, points[out], sigma[out], confidence[out], zones[out], colours[out])

    in_parallel(one, range(len(blocks)))
    return Cloud(points, sigma, confidence, zones, None if rgb is None else colours, frame.timestamp_s)


def zone_cloud(sight: Sight, depths: ZoneDepths, timestamp_s: float) -> Cloud:
    """Without an image: a point for each surface of each zone, in the mean direction in which the zone looks.

    depths: of one frame. sigma_m: standard error and spread of the surface's range, along the optical axis.
    confidence: the part of the zone's view that it fills.
    """
    weight = sight.weights.reshape(sight.zones, -1).astype(float)
    towards = weight @ (sight.rays / sight.ray_length[..., None]).reshape(-1, 3)
    length = np.linalg.norm(towards, axis=1, keepdims=True)
    towards = towards / np.where(length > 0, length, 1)
    zone, surface = np.nonzero(np.isfinite(depths.surface_m) & (length > 0))
    at = zone, surface
    sigma = np.hypot(depths.surface_sigma_m[at], depths.surface_spread_m[at]) * towards[zone, 2]
    points = (towards[zone] * depths.surface_m[at][:, None]).astype(np.float32)
    trust = np.clip(np.nan_to_num(depths.area[at]), 0, 1).astype(np.float32)
    return Cloud(points, sigma.astype(np.float32), trust, zone.astype(np.uint8), None, timestamp_s)


def no_points(timestamp_s: float) -> Cloud:
    """A cloud without points."""
    return Cloud(*(np.empty(shape, np.float32) for shape in ((0, 3), 0, 0)), np.empty(0, np.uint8), None, timestamp_s)


@njit(nogil=True, cache=True)
def _kept(depth, sigma, confidence, most_sigma, least_confidence):
    """Whether a pixel becomes a point; comparisons with NaN are false."""
    return 0 < depth < np.inf and not sigma > most_sigma and not confidence < least_confidence


@njit(nogil=True, cache=True)
def _count(depth, sigma, confidence, most_sigma, least_confidence):
    """How many pixels of these rows become points."""
    count = 0
    for v in range(depth.shape[0]):
        for u in range(depth.shape[1]):
            count += _kept(depth[v, u], sigma[v, u], confidence[v, u], most_sigma, least_confidence)
    return count


@njit(nogil=True, cache=True)
def _fill(
    inverse, first, depth, sigma, confidence, zones, rgb, most_sigma, least, points, sigmas, trust, zone, colours
):
    """Points of the rows from `first` on: X = z · K⁻¹ (u, v, 1)."""
    n = 0
    across = np.float32(inverse[0, 0])
    for v in range(depth.shape[0]):
        # The third row of a pinhole matrix and of its inverse is 0, 0, 1: y is the same along a row without skew.
        start = np.float32(inverse[0, 1] * (first + v) + inverse[0, 2])
        down = np.float32(inverse[1, 1] * (first + v) + inverse[1, 2])
        for u in range(depth.shape[1]):
            z = depth[v, u]
            if not _kept(z, sigma[v, u], confidence[v, u], most_sigma, least):
                continue
            points[n, 0] = z * (across * np.float32(u) + start)
            points[n, 1] = z * down
            points[n, 2] = z
            sigmas[n], trust[n], zone[n] = sigma[v, u], confidence[v, u], zones[v, u]
            if rgb.size:
                colours[n, 0], colours[n, 1], colours[n, 2] = rgb[v, u, 0], rgb[v, u, 1], rgb[v, u, 2]
            n += 1

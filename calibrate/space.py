"""Image-plane maps in space: weighted rays in the LiDAR's own frame, and the map at any other range."""

import json
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from recordings.maps import ResponseMaps
from recordings.refusal import Refusal

# A patch smaller than what a zone sees is lit with 1/r² and seen with 1/r² (physics.radiometry).
FALLOFF = 4


@dataclass(frozen=True, eq=False)
class ScanGeometry:
    """How the image of a scan lies in space.

    intrinsics: (3, 3) pinhole matrix of the full-size image, pixels. lidar_from_camera: (4, 4) rigid transform, metres.
    depth_m: distance of the plane in which the patch moved, along the camera's optical axis.
    """

    intrinsics: np.ndarray
    lidar_from_camera: np.ndarray
    depth_m: float

    @staticmethod
    def of(maps: ResponseMaps) -> "ScanGeometry":
        """The geometry in the meta of the maps; refused where they are image-plane maps only."""
        meta = maps.meta
        wanted = ("intrinsics", "lidar_from_camera", "calibration_range_m")
        if missing := [name for name in wanted if name not in meta]:
            raise Refusal(
                f"meta_json: {', '.join(missing)} missing, so these are image-plane maps; expected maps calibrated "
                "with intrinsics, the mount's baseline and the patch's distance"
            )
        return ScanGeometry(*(np.asarray(meta[name], float) for name in wanted[:2]), float(meta[wanted[2]]))

    def to_meta(self) -> dict[str, Any]:
        """What to add to the meta of maps so that `of` finds the geometry again."""
        return {
            "intrinsics": np.asarray(self.intrinsics, float).tolist(),
            "lidar_from_camera": np.asarray(self.lidar_from_camera, float).tolist(),
            "calibration_range_m": float(self.depth_m),
        }

    def points(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """(N, 3) points of the scan's plane seen at N pixels, in the LiDAR's frame, metres."""
        pixel = np.stack([x, y, np.ones(len(x))], axis=1).astype(float)
        in_camera = self.depth_m * np.linalg.solve(self.intrinsics, pixel.T).T
        return in_camera @ self.lidar_from_camera[:3, :3].T + self.lidar_from_camera[:3, 3]

    def pixels(self, directions: np.ndarray) -> np.ndarray:
        """(N, 2) pixels at which rays from the LiDAR, (N, 3) in its frame, meet the scan's plane; NaN behind it."""
        rotation, translation = self.lidar_from_camera[:3, :3], self.lidar_from_camera[:3, 3]
        origin, along = -rotation.T @ translation, directions @ rotation
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = (self.depth_m - origin[2]) / along[:, 2:]
            seen = (origin + reach * along) @ self.intrinsics.T
            return np.where(reach > 0, seen[:, :2] / seen[:, 2:], np.nan)


@dataclass(frozen=True, eq=False)
class RayBundle:
    """Where P zones look from the LiDAR's own origin, whatever the range.

    directions: (K, 3) unit vectors in the LiDAR's frame. weights, sigma: (P, K) response of a zone to a small patch
    in that direction with the fall-off with range taken out: counts the patch would give at 1 m, and its error.
    """

    directions: np.ndarray
    weights: np.ndarray
    sigma: np.ndarray | None


def rays(maps: ResponseMaps, geometry: ScanGeometry | None = None) -> RayBundle:
    """Turn maps of a scan into rays. R = W(direction) / r⁴ for a patch of constant area (physics.radiometry)."""
    points = (geometry or ScanGeometry.of(maps)).points(maps.xs, maps.ys)
    ranges = np.linalg.norm(points, axis=1)
    return RayBundle(
        directions=points / ranges[:, None],
        weights=maps.by_zone * ranges**FALLOFF,
        sigma=None if maps.sigma is None else maps.sigma.reshape(len(maps.by_zone), -1) * ranges**FALLOFF,
    )


def at_depth(maps: ResponseMaps, depth_m: float) -> ResponseMaps:
    """The maps on a plane at another distance along the optical axis.

    Every sample keeps its ray and moves to the pixel in which the ray meets the new plane; its response falls with
    r⁻⁴. It stays blurred by the angle that the patch filled in the scan, hence by as many pixels.
    """
    if not (np.isfinite(depth_m) and depth_m > 0):
        raise Refusal(f"distance: {depth_m} m found, expected metres above 0")
    here = ScanGeometry.of(maps)
    there = replace(here, depth_m=float(depth_m))
    bundle = rays(maps, here)
    x, y = there.pixels(bundle.directions).T
    if not np.isfinite(x).all():
        raise Refusal(f"distance: a plane at {depth_m} m lies behind the LiDAR for some rays, expected one before it")
    falloff = np.linalg.norm(there.points(x, y), axis=1) ** -FALLOFF
    meta = maps.meta | there.to_meta() | {"moved_from_m": here.depth_m}
    shape = maps.responses.shape
    return replace(
        maps,
        responses=(bundle.weights * falloff).reshape(shape),
        sigma=None if bundle.sigma is None else (bundle.sigma * falloff).reshape(shape),
        xs=x,
        ys=y,
        meta_json=json.dumps(meta),
    )

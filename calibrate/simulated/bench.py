"""The bench of a patch scan: camera, LiDAR beside it, and where the robot holds the patch."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from calibrate.plan import ScanPlan
from calibrate.rig import mounted
from recordings.refusal import Refusal


@dataclass(frozen=True)
class Bench:
    """Where things are. The camera's frame is x right, y down, z forward; lengths in metres.

    image_size, focal_px, principal_px: the camera, a RealSense D435i's colour stream at 848 × 480.
    distortion: first radial coefficient k of its lens, x_image = x (1 + k r²) in tangents.
    lidar_position_m: the LiDAR in the camera's frame, lidar_rotation_deg: its rotation about x, y and z.
    patch_range_m: depth of the scan's plane on the optical axis. patch_radius_m: of the disc, which stays
    parallel to the image plane.
    corners_px: first and last cell, where the plane is untilted and the lens perfect.
    roll_deg, tilt_deg: the plane turned about the optical axis, and about x and y (keystone).
    jitter_m: standard deviation of the robot's position along each axis.
    """

    image_size: tuple[int, int] = (848, 480)
    focal_px: float = 612.0
    principal_px: tuple[float, float] = (423.5, 239.5)
    distortion: float = 0.008
    lidar_position_m: tuple[float, float, float] = (0.053, 0.024, -0.02)
    lidar_rotation_deg: tuple[float, float, float] = (0.3, -0.4, 0.5)
    patch_range_m: float = 0.6
    patch_radius_m: float = 0.0174
    corners_px: tuple[float, float, float, float] = (20.0, 458.0, 832.0, 22.0)
    roll_deg: float = 0.6
    tilt_deg: tuple[float, float] = (0.3, -3.0)
    jitter_m: float = 1e-4

    def __post_init__(self) -> None:
        for name in ("focal_px", "patch_range_m", "patch_radius_m"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0):
                raise Refusal(f"bench: {name} is {value!r}, expected a positive number")
        if self.patch_radius_m > self.patch_range_m / 2:
            raise Refusal(
                f"bench: patch_radius_m is {self.patch_radius_m} at a range of {self.patch_range_m} m, "
                "expected at most half the range"
            )

    def at_range(self, patch_range_m: float) -> "Bench":
        """The same bench with the scan's plane at another depth."""
        return replace(self, patch_range_m=patch_range_m)

    @property
    def intrinsics(self) -> np.ndarray:
        """(3, 3) pinhole matrix, pixel centres at integers."""
        x, y = self.principal_px
        return np.array([[self.focal_px, 0, x], [0, self.focal_px, y], [0, 0, 1.0]])

    @property
    def lidar_from_camera(self) -> np.ndarray:
        """(4, 4) rigid transform."""
        return mounted(self.lidar_position_m, self.lidar_rotation_deg)

    def to_lidar(self, points_m: np.ndarray) -> np.ndarray:
        """Points (..., 3) of the camera's frame in the LiDAR's."""
        transform = self.lidar_from_camera
        return points_m @ transform[:3, :3].T + transform[:3, 3]

    def project(self, points_m: np.ndarray) -> np.ndarray:
        """(..., 2) pixels of points (..., 3) in the camera's frame, through pinhole and lens."""
        tangents = points_m[..., :2] / points_m[..., 2:]
        stretched = tangents * (1 + self.distortion * np.square(tangents).sum(axis=-1, keepdims=True))
        return stretched * self.focal_px + self.principal_px

    def patch_positions(self, plan: ScanPlan, rng: np.random.Generator) -> np.ndarray:
        """(K, 3) metres, centre of the patch at each cell in the camera's frame.

        A regular grid that fills `corners_px` at the optical axis' depth, rolled, tilted, and met with
        jitter.
        """
        x0, y0, x1, y1 = self.corners_px
        along = (plan.cells + 0.5) / (plan.columns, plan.rows)
        if plan.columns > 1 and plan.rows > 1:
            along = plan.cells / (plan.columns - 1, plan.rows - 1)
        pixels = (x0, y0) + along * (x1 - x0, y1 - y0)
        plane = (pixels - self.principal_px) * self.patch_range_m / self.focal_px
        turn = Rotation.from_euler("zxy", [self.roll_deg, *self.tilt_deg], degrees=True)
        points = turn.apply(np.column_stack([plane, np.zeros(len(plane))]))
        points[:, 2] += self.patch_range_m
        return points + rng.normal(0, self.jitter_m, points.shape)

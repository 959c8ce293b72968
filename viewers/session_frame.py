"""What a session shows: of the rig, once; and of every frame."""

from dataclasses import dataclass

import numpy as np

from fusion.cloud import Cloud
from fusion.fused import FusedFrame
from recordings.refusal import Refusal


@dataclass(frozen=True, eq=False)
class SessionRig:
    """What holds for all frames of a session.

    zone_grid: rows, columns of P zones. range_m: (P, T) metres, range whose light arrives in the middle of each bin;
    None where no histograms will be shown.
    footprints: (P, h, w) weights over the camera's field, None where nobody knows where the zones look.
    title: what the session is of. sentences: what else a colleague should read first.
    start_s: timestamp that the timeline calls 0; that of the first frame where None.
    first_pose: (4, 4) world from camera, where the eye starts from; the world's origin where None.
    has_pictures, has_depth, has_residuals, has_recorded_depth, has_latency: which panels to open with.
    """

    zone_grid: tuple[int, int]
    range_m: np.ndarray | None = None
    footprints: np.ndarray | None = None
    title: str = "difflidar"
    sentences: tuple[str, ...] = ()
    start_s: float | None = None
    first_pose: np.ndarray | None = None
    has_pictures: bool = True
    has_depth: bool = True
    has_residuals: bool = False
    has_recorded_depth: bool = False
    has_latency: bool = False

    def __post_init__(self) -> None:
        zones = self.zone_grid[0] * self.zone_grid[1]
        for name, axes in (("range_m", 2), ("footprints", 3)):
            value = getattr(self, name)
            if value is not None and (np.ndim(value) != axes or len(value) != zones):
                raise Refusal(f"{name} has shape {np.shape(value)}, expected {axes} axes, the first of {zones} zones")

    @property
    def zones(self) -> list[str]:
        """Row and column of every zone, as `1_2`."""
        rows, columns = self.zone_grid
        return [f"{row}_{column}" for row in range(rows) for column in range(columns)]


@dataclass(frozen=True, eq=False)
class SessionFrame:
    """What a session shows of one time; what is None is not there, and the panel keeps what it showed before.

    timestamp_s: seconds. counts: (P, T). surface_m, surface_share: (P, S) range of each surface that a zone sees,
    metres, NaN where there are fewer, and its share of the zone's light, 0 to 1.
    fused: depth and its uncertainty; its image and pose are shown unless `rgb` or `pose` are given, too.
    cloud: its points in the camera's frame; made of `fused` where None.
    rgb: (H, W, 3) uint8, or the bytes of a PNG or JPEG. intrinsics: (3, 3) of its H × W grid; those of `fused` where
    None. pose: (4, 4) world from camera.
    expected: (P, T) counts of a simulation, for residuals. recorded_depth_m: (H, W) what a depth camera saw.
    latency_s: from the arrival of the measurement to here, in a live session.
    """

    timestamp_s: float
    counts: np.ndarray | None = None
    surface_m: np.ndarray | None = None
    surface_share: np.ndarray | None = None
    fused: FusedFrame | None = None
    cloud: Cloud | None = None
    rgb: np.ndarray | bytes | None = None
    intrinsics: np.ndarray | None = None
    pose: np.ndarray | None = None
    expected: np.ndarray | None = None
    recorded_depth_m: np.ndarray | None = None
    latency_s: float | None = None

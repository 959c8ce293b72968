"""The Recording: what a diffuse LiDAR, and the camera beside it, saw."""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from recordings.checks import check_recording


@dataclass(frozen=True, eq=False)
class Recording:
    """What a diffuse LiDAR and its camera saw in F frames, P zones, T bins and an H × W camera grid.

    Fields as in the recording format; SI units; camera frame x right, y down, z forward. Numbers keep the type
    they came in, signed counts aside. Fields of the camera grid may be frames that are read from their file when
    indexed (`LazyFrames`, `EncodedFrames`); `np.asarray` reads them all.

    counts: (F, P, T) unsigned integers, photon detections per frame, zone and bin; never scaled.
    zone_grid: (2,) rows, columns of the zones, row-major in the sensor's own order; their product is P.
    bin_width_s: () seconds, width of a bin.
    time_zero_s: () or (P,) seconds, arrival of a target at range 0 from the start of bin 0.
    timestamp_s: (F,) seconds, strictly increasing.
    laser_cycles: () or (F,), laser shots accumulated into a frame.
    irf_time_s, irf: (N,) each, impulse response: probability per step, sums to 1; time 0 is the nominal arrival.
    background_counts: (P,) counts per bin without laser.
    depth_m: (F, H, W) or (H, W) metres along the optical axis, NaN where unknown.
    reflectance: like depth_m, assumed near-infrared reflectance, 0 to 1.
    incidence_cosine: like depth_m, cosine between surface normal and ray to the sensor.
    rgb: (F, H, W, 3) or (H, W, 3) uint8.
    intrinsics: (3, 3) pinhole matrix in pixels of the H × W grid, pixel centres at integers.
    image_size: (2,) width, height of that grid.
    lidar_from_camera: (4, 4) rigid transform.
    camera_pose: (F, 4, 4) world from camera.
    patch_px: (F, 2) patch centre in the full-size image, for a calibration scan; NaN where there is no patch.
    meta_json: JSON text; `meta` is what it says.

    Raises `Refusal` with one sentence naming the array, the value at fault and what was expected.
    """

    counts: np.ndarray
    zone_grid: np.ndarray
    bin_width_s: np.ndarray
    time_zero_s: np.ndarray
    timestamp_s: np.ndarray
    laser_cycles: np.ndarray | None = None
    irf_time_s: np.ndarray | None = None
    irf: np.ndarray | None = None
    background_counts: np.ndarray | None = None
    depth_m: np.ndarray | None = None
    reflectance: np.ndarray | None = None
    incidence_cosine: np.ndarray | None = None
    rgb: Sequence[np.ndarray] | None = None
    intrinsics: np.ndarray | None = None
    image_size: np.ndarray | None = None
    lidar_from_camera: np.ndarray | None = None
    camera_pose: np.ndarray | None = None
    patch_px: np.ndarray | None = None
    meta_json: str = "{}"

    def __post_init__(self) -> None:
        check_recording(self)

    @property
    def meta(self) -> dict[str, Any]:
        """What `meta_json` says."""
        return json.loads(self.meta_json)

    def assumes(self, name: str) -> bool:
        """Whether whoever made it had no better than to assume this field, as an importer says under `assumed`."""
        return name in str(self.meta.get("assumed", ""))

    def present(self) -> Iterator[tuple[str, Any]]:
        """Name and value of every field that is there."""
        for field in fields(self):
            value = getattr(self, field.name)
            if value is not None:
                yield field.name, value

"""One view of a scene, and the views along a trajectory."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np


@dataclass(frozen=True, eq=False)
class View:
    """What a camera grid of H × W pixels sees of a scene at one time.

    timestamp_s: seconds. depth_m: (H, W) metres along the optical axis, NaN where nothing is or is known.
    reflectance: (H, W) in the near infrared, 0 to 1; 1 where None. incidence_cosine: (H, W), from depth where None.
    gloss: (H, W) how many times as bright as a matt surface of that reflectance, 1 where None; no recording carries it.
    rgb: (H, W, 3) uint8, or the bytes of a PNG or JPEG. camera_pose: (4, 4) world from camera.
    """

    timestamp_s: float
    depth_m: np.ndarray
    reflectance: np.ndarray | None = None
    incidence_cosine: np.ndarray | None = None
    gloss: np.ndarray | None = None
    rgb: np.ndarray | bytes | None = None
    camera_pose: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class Views:
    """Views in the order of time, to be run through once; all have the same grid and the same fields.

    intrinsics: (3, 3) pinhole matrix of the grid, pixel centres at integers. count: how many views will come, None
    where nobody knows. lidar_from_camera: (4, 4) rigid transform, None where unknown. meta: what the scene says of
    itself.
    """

    intrinsics: np.ndarray
    views: Iterator[View]
    count: int | None
    lidar_from_camera: np.ndarray | None = None
    meta: dict[str, Any] = field(default_factory=dict)

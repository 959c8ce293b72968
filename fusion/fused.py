"""What fusion makes of one frame: a depth for every pixel of the camera, and how far to believe it."""

from dataclasses import dataclass

import numpy as np

from recordings.refusal import Refusal

# In `zones`, where no zone sees the pixel.
NO_ZONE = 255


@dataclass(frozen=True, eq=False)
class FusedFrame:
    """Depth on a camera grid of H × W pixels.

    timestamp_s: seconds. depth_m: (H, W) float32 metres along the optical axis, NaN where nothing is known.
    sigma_m: (H, W) float32 metres, standard error of depth. confidence: (H, W) float32, 0 to 1, how much of the
    pixel's depth the sensor rather than the prior says. zones: (H, W) uint8, the zone that contributes most, 255 where
    none does. rgb: (H, W, 3) uint8, None where no camera frame was there. intrinsics: (3, 3) pixels of the grid.
    pose: (4, 4) world from camera, None where unknown. method: by which depth was found.

    Raises `Refusal` where an image has another shape than depth.
    """

    timestamp_s: float
    depth_m: np.ndarray
    sigma_m: np.ndarray
    confidence: np.ndarray
    zones: np.ndarray
    rgb: np.ndarray | None
    intrinsics: np.ndarray
    pose: np.ndarray | None
    method: str

    def __post_init__(self) -> None:
        shape = self.depth_m.shape
        if len(shape) != 2:
            raise Refusal(f"depth_m has shape {shape}, expected (H, W)")
        images = {"sigma_m": shape, "confidence": shape, "zones": shape, "rgb": (*shape, 3)}
        for name, expected in images.items():
            image = getattr(self, name)
            if image is not None and image.shape != expected:
                raise Refusal(f"{name} has shape {image.shape}, expected {expected} as depth_m")

    @property
    def known(self) -> np.ndarray:
        """(H, W) bool, where there is a depth."""
        return np.isfinite(self.depth_m)

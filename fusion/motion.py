"""Earlier images of a camera that moves, and which of them tells depth in the present one."""

from collections import deque
from dataclasses import dataclass

import cv2
import numpy as np

from fusion.sight import Sight

# Images are compared on a grid so many times as fine as the coarse one.
FINER = 2
# Views that are kept; those of a robot that stands do not crowd out the others.
KEPT = 8
# Parts of the range by which the camera has moved: too little to tell depth, best, and so much that the views differ.
LEAST, BEST, MOST = 0.004, 0.03, 0.15
MOST_TURN_DEG = 12.0


@dataclass(frozen=True, eq=False)
class Motion:
    """An earlier image, (h, w) float32 grey from 0 to 255, and its camera from that of now, (4, 4), metres."""

    grey: np.ndarray
    step: np.ndarray


class Earlier:
    """The last views of a camera with their poses; bounded, whatever comes."""

    def __init__(self, sight: Sight) -> None:
        self._shape = finer(sight.coarse.shape)
        self._views: deque[tuple[np.ndarray, np.ndarray]] = deque(maxlen=KEPT)

    def add(self, rgb: np.ndarray | None, pose: np.ndarray | None, range_m: float) -> None:
        """Keep a view, (H, W, 3) uint8, of things at about `range_m`, with its pose, (4, 4) world from camera.

        One without image or pose tells nothing, nor does one from where the last was.
        """
        if rgb is None or pose is None:
            return
        if self._views and moved(np.linalg.inv(self._views[-1][1]) @ pose) < LEAST * range_m:
            return
        self._views.append((grey(rgb, self._shape), np.array(pose, float)))

    def motion(self, pose: np.ndarray | None, range_m: float) -> Motion | None:
        """The view whose distance is nearest in ratio to BEST of the range; None where none is between the bounds."""
        if pose is None:
            return None
        motions = [Motion(seen, np.linalg.inv(was) @ pose) for seen, was in self._views]
        told = [m for m in motions if LEAST < moved(m.step) / range_m < MOST and turned_deg(m.step) < MOST_TURN_DEG]
        return min(told, key=lambda m: abs(np.log(moved(m.step) / range_m / BEST)), default=None)


def finer(shape: tuple[int, int]) -> tuple[int, int]:
    """(h, w) of the grid on which images are compared."""
    return FINER * shape[0], FINER * shape[1]


def grey(rgb: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """(h, w) float32 grey, 0 to 255, of an image (H, W, 3) uint8."""
    small = cv2.resize(rgb, shape[::-1], interpolation=cv2.INTER_AREA)
    return cv2.cvtColor(small, cv2.COLOR_RGB2GRAY).astype(np.float32)


def moved(step: np.ndarray) -> float:
    """Metres."""
    return float(np.linalg.norm(step[:3, 3]))


def turned_deg(step: np.ndarray) -> float:
    """Angle of the rotation: a camera that only turns sees the same whatever the depth."""
    return float(np.degrees(np.arccos(np.clip((np.trace(step[:3, :3]) - 1) / 2, -1, 1))))

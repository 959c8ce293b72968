"""How the camera moved through a scene: what stands still outside its view is elsewhere in every frame."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation


@dataclass(frozen=True, eq=False)
class Motion:
    """Where the camera was. time_s: (N,) since the first frame of the session. start_from_camera: (N, 4, 4) rigid
    transforms from its frame at that time to that at the session's beginning.
    """

    time_s: np.ndarray
    start_from_camera: np.ndarray

    @classmethod
    def of(cls, time_s: np.ndarray, pose: np.ndarray | None, start: np.ndarray | None = None) -> "Motion | None":
        """From poses (N, 4, 4), world from camera, and that at the beginning, the first where not given.

        None where poses are not known: then the camera is taken to stand still.
        """
        if pose is None:
            return None
        poses = np.asarray(pose, float)
        return cls(np.asarray(time_s, float), np.linalg.inv(poses[0] if start is None else start) @ poses)

    def plane(self, normal: np.ndarray, distance_m: float, time_s: float) -> tuple[np.ndarray, float]:
        """A plane n·X = d of the frame at the beginning, its normal (3,) and distance in the camera's frame then."""
        there = self.start_from_camera[int(np.argmin(np.abs(self.time_s - time_s)))]
        return there[:3, :3].T @ normal, float(distance_m - normal @ there[:3, 3])

    def at(self, time_s: np.ndarray) -> np.ndarray:
        """(F, 4, 4) where it was at any times: evenly on from one of its own to the next, and as it did beyond.

        Straight on, and turning about one axis (Rodrigues' vectors).
        """
        last = len(self.time_s) - 1
        lower = np.clip(np.searchsorted(self.time_s, time_s, side="right") - 1, 0, max(last - 1, 0))
        upper = np.minimum(lower + 1, last)
        span = self.time_s[upper] - self.time_s[lower]
        part = np.where(span > 0, (np.asarray(time_s, float) - self.time_s[lower]) / np.where(span > 0, span, 1), 0.0)
        before, after = self.start_from_camera[lower], self.start_from_camera[upper]
        turned = Rotation.from_matrix(np.swapaxes(before[:, :3, :3], 1, 2) @ after[:, :3, :3]).as_rotvec()
        out = before.copy()
        out[:, :3, :3] = before[:, :3, :3] @ Rotation.from_rotvec(turned * part[:, None]).as_matrix()
        out[:, :3, 3] += part[:, None] * (after[:, :3, 3] - before[:, :3, 3])
        return out

    def forward_m(self, time_s: np.ndarray) -> np.ndarray:
        """(F,) how far it has moved along the axis on which it looked at the beginning."""
        return self.start_from_camera[self.nearest(time_s), 2, 3]

    def nearest(self, time_s: np.ndarray) -> np.ndarray:
        """(F,) which of its own times are nearest to these."""
        return np.abs(self.time_s[:, None] - np.asarray(time_s, float)).argmin(axis=0)

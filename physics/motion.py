"""How the camera moved through a scene: what stands still outside its view is elsewhere in every frame."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, RotationSpline


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
        """(F, 4, 4) where it was at any times: through its own by cubic splines, evenly on before the first of them and
        after the last.
        """
        time_s = np.asarray(time_s, float)
        out = np.tile(self.start_from_camera[int(np.argmin(self.time_s))], (len(time_s), 1, 1))
        if np.ptp(self.time_s) == 0:
            return out
        turned, place = self._splines
        within = np.clip(time_s, place.x[0], place.x[-1])
        # A spline's rate is about axes of the camera by then: what goes on evenly turns about the same ones.
        on = (time_s - within)[:, None]
        out[:, :3, :3] = (turned(within) * Rotation.from_rotvec(turned(within, 1) * on)).as_matrix()
        out[:, :3, 3] = place(within) + place(within, 1) * on
        return out

    @cached_property
    def _splines(self) -> tuple[RotationSpline, CubicSpline]:
        """Through its turns, and through its places: a fit asks for the same way at many times."""
        own, first = np.unique(self.time_s, return_index=True)
        poses = self.start_from_camera[first]
        return RotationSpline(own, Rotation.from_matrix(poses[:, :3, :3])), CubicSpline(own, poses[:, :3, 3])

    def moved_m(self, time_s: np.ndarray) -> np.ndarray:
        """(F, 3) how far it has moved to the right, down, and ahead of what it looked at in the beginning."""
        return self.start_from_camera[self.nearest(time_s), :3, 3]

    def nearest(self, time_s: np.ndarray) -> np.ndarray:
        """(F,) which of its own times are nearest to these."""
        return np.abs(self.time_s[:, None] - np.asarray(time_s, float)).argmin(axis=0)

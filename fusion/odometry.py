"""Where the camera went, from colour and fused depth, by Open3D's odometry."""

import numpy as np

from fusion.fused import FusedFrame
from recordings.refusal import Refusal

# Odometry runs on images of about this width: its cost is bounded, and the depth of few zones holds no more.
WIDTH_PX = 320
# Share of pixels that find a partner, below which the motion is taken to be unknown.
LEAST_FITNESS = 0.3
# Depths of one point in two frames may differ by so many standard errors of them.
SIGMAS = 3.0
FARTHEST_M = 10.0


class Odometry:
    """Poses of frames that come without, one after another: colour and depth of each against the last (Park, Zhou &
    Koltun, Colored point cloud registration revisited, 2017, as Open3D's `Hybrid` method).

    The first frame is at the origin. A frame whose motion cannot be told has no pose, and the next is tried against
    the last that has one: a pose is never guessed. lost: how many frames had none.
    """

    def __init__(self) -> None:
        self.lost = 0
        self._pose = np.eye(4)
        self._last = None

    def push(self, frame: FusedFrame) -> np.ndarray | None:
        """(4, 4) world from camera of this frame; None where it cannot be told."""
        if frame.rgb is None:
            raise Refusal("odometry needs colour, and the frame has no rgb")
        here, allowed_m, intrinsics = _prepared(frame)
        motion = np.eye(4) if self._last is None else _motion(here, self._last, allowed_m, intrinsics)
        if motion is None:
            self.lost += 1
            return None
        self._last, self._pose = here, self._pose @ motion
        return self._pose.copy()


def _prepared(frame: FusedFrame) -> tuple:
    """Open3D's image of colour and depth, at most WIDTH_PX wide; by how much depth may differ; intrinsics."""
    import open3d.core as core
    from open3d.t.geometry import Image, RGBDImage

    step = max(1, frame.depth_m.shape[1] // WIDTH_PX)
    at = (slice(step // 2, None, step),) * 2
    depth = np.nan_to_num(frame.depth_m[at], posinf=0, neginf=0).astype(np.float32)
    known = frame.sigma_m[at][depth > 0]
    allowed_m = SIGMAS * float(np.median(known[np.isfinite(known)])) if np.isfinite(known).any() else 0.1
    intrinsics = np.asarray(frame.intrinsics, float).copy()
    intrinsics[:2, 2] -= step // 2
    intrinsics[:2] /= step
    colour = np.ascontiguousarray(frame.rgb[at], np.uint8)
    images = [Image(core.Tensor.from_numpy(np.ascontiguousarray(a))) for a in (colour, depth[..., None])]
    return RGBDImage(*images), float(np.clip(allowed_m, 0.05, 1.0)), core.Tensor(intrinsics)


def _motion(here, last, allowed_m: float, intrinsics) -> np.ndarray | None:
    """(4, 4) last frame from this one, None where too few pixels agree or the equations cannot be solved."""
    import open3d.core as core
    from open3d.t.pipelines import odometry

    steps = [odometry.OdometryConvergenceCriteria(n) for n in (10, 5, 3)]
    loss = odometry.OdometryLossParams(depth_outlier_trunc=allowed_m, depth_huber_delta=allowed_m / 2)
    start, method = core.Tensor(np.eye(4)), odometry.Method.Hybrid
    try:
        found = odometry.rgbd_odometry_multi_scale(here, last, intrinsics, start, 1.0, FARTHEST_M, steps, method, loss)
    except RuntimeError:  # Singular equations: no depth, or nothing to see.
        return None
    motion = found.transformation.numpy()
    return motion if found.fitness >= LEAST_FITNESS and np.isfinite(motion).all() else None

"""What an earlier frame says of the present view, by the camera's poses."""

import cv2
import numpy as np

from fusion.sight import Sight


def carried(sight: Sight, depth_m: np.ndarray, pose: np.ndarray, pose_now: np.ndarray) -> np.ndarray:
    """(h, w) metres on the coarse grid of `sight`: depth (H, W) seen from `pose`, as seen from `pose_now`; else NaN.

    Poses are world from camera, (4, 4). Each coarse pixel's point goes to the pixel that it falls on; of several the
    nearest is seen. Depth that the sensor did not know is NaN and stays behind.
    """
    grid = sight.coarse
    height, width = grid.shape
    small = cv2.resize(np.asarray(depth_m, np.float32), (width, height), interpolation=cv2.INTER_NEAREST)
    points = (grid.rays * small[..., None]).reshape(-1, 3).astype(float)
    points = points[np.isfinite(points).all(axis=1)]
    step = np.linalg.inv(np.asarray(pose_now, float)) @ np.asarray(pose, float)
    points = points @ step[:3, :3].T + step[:3, 3]
    points = points[points[:, 2] > 0]
    column, row = np.rint((points / points[:, 2:]) @ grid.intrinsics.T[:, :2]).astype(int).T
    inside = (row >= 0) & (row < height) & (column >= 0) & (column < width)
    found = np.full(grid.shape, np.inf)
    np.minimum.at(found, (row[inside], column[inside]), points[inside, 2])
    return np.where(np.isfinite(found), found, np.nan)

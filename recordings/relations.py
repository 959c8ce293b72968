"""What the arrays of a recording must be to one another."""

from typing import Any

import numpy as np

from recordings.refusal import Refusal

# A pose read from four decimals of text is orthonormal to about this.
RIGID_TOLERANCE = 1e-3
# An impulse response summed in float32 reaches 1 to about this.
SUM_TOLERANCE = 1e-4
# Times of an impulse response in float32 are even to about this share of a step.
STEP_TOLERANCE = 0.01


def check_relations(values: dict[str, Any], sizes: dict[str, int]) -> None:
    """Refuse arrays, each well formed, that contradict one another; `values` may lack any but `zone_grid`."""
    rows, columns = (int(n) for n in values["zone_grid"])
    if sizes.get("P", rows * columns) != rows * columns:
        raise Refusal(f"zone_grid is {rows} x {columns}, expected a product of {sizes['P']}, the number of zones")
    if values.get("timestamp_s") is not None:
        check_increasing("timestamp_s", values["timestamp_s"])
    check_irf(values.get("irf_time_s"), values.get("irf"), float(values["bin_width_s"]))
    size = values.get("image_size")
    if size is not None and "H" in sizes and tuple(size) != (sizes["W"], sizes["H"]):
        there = f"{sizes['W']} x {sizes['H']}"
        raise Refusal(f"image_size is {size[0]} x {size[1]}, expected {there} (width x height) as the images")
    if values.get("intrinsics") is not None:
        check_pinhole(values["intrinsics"])
    if values.get("lidar_from_camera") is not None:
        check_rigid("lidar_from_camera", values["lidar_from_camera"])
    for i, pose in enumerate(() if values.get("camera_pose") is None else values["camera_pose"]):
        check_rigid(f"camera_pose[{i}]", pose)


def check_increasing(name: str, times: np.ndarray) -> None:
    """Refuse times that stand still or go back."""
    later = times[1:] > times[:-1]
    if not later.all():
        i = int(np.argmin(later)) + 1
        raise Refusal(f"{name}[{i}] is {times[i]} after {times[i - 1]}, expected strictly increasing seconds")


def check_irf(time: np.ndarray | None, irf: np.ndarray | None, bin_width_s: float) -> None:
    """Refuse half an impulse response, uneven or coarse steps, and a sum that is not 1."""
    if time is None and irf is None:
        return
    if time is None or irf is None:
        there, absent = ("irf_time_s", "irf") if irf is None else ("irf", "irf_time_s")
        raise Refusal(f"{there} is there but {absent} is missing, expected both or neither")
    if len(time) < 2:
        raise Refusal("irf_time_s has 1 sample, expected at least 2 so that the step is known")
    check_increasing("irf_time_s", time)
    steps = np.diff(time.astype(float))
    step = float(np.median(steps))
    i = int(np.argmax(np.abs(steps - step)))
    if abs(steps[i] - step) > STEP_TOLERANCE * step:
        raise Refusal(f"irf_time_s steps by {steps[i]:.4g} s at index {i}, expected even steps of {step:.4g} s")
    if step > bin_width_s * (1 + STEP_TOLERANCE):
        raise Refusal(f"irf_time_s steps by {step:.4g} s, expected finer than a bin of {bin_width_s:.4g} s")
    total = float(irf.sum(dtype=float))
    if abs(total - 1) > SUM_TOLERANCE:
        raise Refusal(f"irf sums to {total:.6g}, expected 1")


def check_pinhole(intrinsics: np.ndarray) -> None:
    """Refuse a matrix that is no pinhole camera's."""
    for i in (0, 1):
        if not intrinsics[i, i] > 0:
            raise Refusal(f"intrinsics[{i}, {i}] is {intrinsics[i, i]}, expected a positive focal length")
    if intrinsics[1, 0] != 0 or tuple(intrinsics[2]) != (0, 0, 1):
        raise Refusal("intrinsics is not a pinhole matrix, expected 0 at [1, 0] and a last row of 0 0 1")


def check_rigid(name: str, pose: np.ndarray) -> None:
    """Refuse a (4, 4) matrix that is not a rotation and a translation."""
    rotation = np.asarray(pose[:3, :3], float)
    if np.abs(rotation).max() > 2 or np.abs(rotation @ rotation.T - np.eye(3)).max() > RIGID_TOLERANCE:
        raise Refusal(f"{name} has rows that are not orthonormal, expected a rotation and a translation")
    if np.linalg.det(rotation) < 0:
        raise Refusal(f"{name} mirrors, expected a rotation and a translation")
    if tuple(pose[3]) != (0, 0, 0, 1):
        raise Refusal(f"{name} has the last row {tuple(pose[3].tolist())}, expected 0, 0, 0, 1")

"""Errors of a depth image against the depth that was there."""

import cv2
import numpy as np

# Depth that changes by this factor between neighbours 4 pixels apart is an edge; pixels this near to one lie at it.
EDGE, STRIDE_PX, NEAR_PX = 1.1, 4, 8
CLOSE = 1.05
# Of a normal distribution, 90 % lie within so many standard deviations.
NINETY = 1.645


def errors(depth: np.ndarray, truth: np.ndarray, where: np.ndarray) -> dict[str, float]:
    """Of pixels (H, W) `where`: rms and median absolute error in metres, share within 5 %, rms at edges of the truth.

    Pixels whose truth is NaN do not count. An estimate that is NaN is as wrong as 0 m, lest silence be rewarded.
    """
    counted = where & np.isfinite(truth)
    off = np.nan_to_num(depth) - truth
    ratio = np.nan_to_num(depth)[counted] / truth[counted]
    near = counted & at_edges(truth)
    return {
        "rms": float(np.sqrt(np.mean(off[counted] ** 2))),
        "median": float(np.median(np.abs(off[counted]))),
        "close": float(np.mean((ratio < CLOSE) & (ratio > 1 / CLOSE))),
        "edges": float(np.sqrt(np.mean(off[near] ** 2))) if near.any() else float("nan"),
    }


def at_edges(truth: np.ndarray) -> np.ndarray:
    """(H, W) bool: near a jump of depth; where depth is unknown there is none."""
    jump = np.zeros(truth.shape, np.uint8)
    log = np.log(truth)
    for axis in (0, 1):
        ahead = np.roll(log, -STRIDE_PX, axis)
        steep = np.abs(ahead - log) > np.log(EDGE)
        np.swapaxes(steep, 0, axis)[-STRIDE_PX:] = False
        jump |= steep.astype(np.uint8)
    return cv2.dilate(jump, np.ones((2 * NEAR_PX + 1, 2 * NEAR_PX + 1), np.uint8)) > 0


def coverage(depth: np.ndarray, sigma: np.ndarray, truth: np.ndarray, where: np.ndarray) -> float:
    """Share of pixels whose truth lies in the 90 % interval of a normal distribution."""
    counted = where & np.isfinite(truth)
    return float(np.mean(np.abs(depth - truth)[counted] < NINETY * sigma[counted]))

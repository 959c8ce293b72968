"""What a depth image of so many regions of like colour could reach, were the depth of each known."""

import cv2
import numpy as np

from fusion.quality.metrics import errors
from fusion.quality.trial import Trial

# Side of a coarse pixel, and what a difference of colour (CIE Lab, white 1) of 1 is worth in coarse pixels.
COARSE, COLOUR_PX = 8, 20.0


def oracle_rms(trial: Trial, regions: int) -> list[float]:
    """Rms error in metres of each frame, every region (k-means of colour and place) at the mean of its true depth."""
    found = []
    for rgb, truth in zip(trial.rgb, trial.depth_m, strict=True):
        height, width = (n // COARSE for n in truth.shape)
        small = cv2.resize(rgb, (width, height), interpolation=cv2.INTER_AREA).astype(np.float32) / 255
        lab = cv2.cvtColor(small, cv2.COLOR_RGB2LAB) / 100
        v, u = np.mgrid[:height, :width].astype(np.float32)
        points = np.concatenate([COLOUR_PX * lab, v[..., None], u[..., None]], axis=-1).reshape(-1, 5)
        cv2.setRNGSeed(0)
        labels = cv2.kmeans(points, regions, None, (3, 30, 0.1), 1, cv2.KMEANS_PP_CENTERS)[1]
        coarse = labels.reshape(height, width).astype(np.uint16)
        of = cv2.resize(coarse, truth.shape[::-1], interpolation=cv2.INTER_NEAREST)
        known = trial.seen & np.isfinite(truth)
        count = np.maximum(np.bincount(of[known], minlength=regions), 1)
        mean = np.bincount(of[known], truth[known], regions) / count
        found.append(errors(mean[of], truth, trial.seen)["rms"])
    return found

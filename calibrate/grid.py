"""Response maps as images: the continuous maps on a regular grid of image points."""

import numpy as np
from scipy.spatial import ConvexHull, Delaunay

from calibrate.kernel import Kernel
from recordings.maps import ResponseMaps


def map_images(kernel: Kernel, maps: ResponseMaps, step_px: int = 4) -> np.ndarray:
    """(P, H / step, W / step) response of each zone, as a scan with this patch sees it, over the full-size image.

    Pixel (i, j) is the response at the centre of a block of step × step full-size pixels; NaN outside the hull of
    the scan positions, where nothing was measured.
    """
    width, height = maps.image_size
    x = np.arange(step_px / 2 - 0.5, width, step_px)
    y = np.arange(step_px / 2 - 0.5, height, step_px)
    points = np.stack([g.ravel() for g in np.meshgrid(x, y)], axis=1)
    scanned = np.stack([maps.xs, maps.ys], axis=1).astype(float)
    inside = Delaunay(scanned[ConvexHull(scanned).vertices]).find_simplex(points) >= 0
    images = np.full((len(kernel.coefficients), len(points)), np.nan)
    images[:, inside] = kernel.response(*points[inside].T)
    return images.reshape(-1, len(y), len(x))

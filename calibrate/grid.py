"""Response maps as images: the continuous maps and their errors on a regular grid of image points."""

from collections.abc import Callable

import numpy as np
from scipy.spatial import ConvexHull, Delaunay, QhullError

from calibrate.kernel import Kernel
from recordings.maps import ResponseMaps
from recordings.progress import Progress, silent
from recordings.refusal import Refusal

PARTS = 20  # of the image, from left to right: bounds the memory and lets progress show


def map_images(kernel: Kernel, maps: ResponseMaps, step_px: int = 4, deconvolved: bool = False) -> np.ndarray:
    """(P, H / step, W / step) response of each zone over the full-size image, counts.

    Pixel (i, j) is the response at the centre of a block of step × step full-size pixels, as a scan with this patch
    sees it or, deconvolved, freed of the patch's size; NaN outside the hull of the scan positions, where nothing was
    measured.
    """
    return _images(kernel.density if deconvolved else kernel.response, maps, step_px)


def sigma_images(
    kernel: Kernel, maps: ResponseMaps, step_px: int = 4, deconvolved: bool = False, progress: Progress = silent
) -> np.ndarray:
    """(P, H / step, W / step) standard errors of `map_images`, counts."""
    return _images(kernel.density_sigma if deconvolved else kernel.response_sigma, maps, step_px, progress)


def _images(
    evaluate: Callable[[np.ndarray, np.ndarray], np.ndarray],
    maps: ResponseMaps,
    step_px: int,
    progress: Progress = silent,
) -> np.ndarray:
    width, height = maps.image_size
    if not 1 <= step_px <= min(width, height):
        raise Refusal(f"step: {step_px} px found, expected 1 to {min(width, height)}, the height of the image")
    x = np.arange(step_px / 2 - 0.5, width, step_px)
    y = np.arange(step_px / 2 - 0.5, height, step_px)
    scanned = np.stack([maps.xs, maps.ys], axis=1).astype(float)
    try:
        hull = Delaunay(scanned[ConvexHull(scanned).vertices])
    except QhullError:
        raise Refusal("xs, ys: the scan positions lie on one line, expected them to span an area") from None
    images = np.full((len(maps.by_zone), len(y), len(x)), np.nan)
    parts = np.array_split(np.arange(len(x)), min(PARTS, len(x)))
    for part in progress(parts, len(parts), "maps over the image"):
        points = np.stack([g.ravel() for g in np.meshgrid(x[part], y)], axis=1)
        inside = hull.find_simplex(points) >= 0
        values = np.full((len(images), len(points)), np.nan)
        if inside.any():
            values[:, inside] = evaluate(*points[inside].T)
        images[:, :, part] = values.reshape(-1, len(y), len(part))
    return images

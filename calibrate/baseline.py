"""Where the LiDAR sits beside the camera, from two scans of one sensor at different ranges."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from calibrate.consistency import centroids
from calibrate.kernel import Kernel, fit_kernel
from calibrate.space import FALLOFF, ScanGeometry
from recordings.maps import ResponseMaps
from recordings.progress import Progress, silent
from recordings.refusal import Refusal

APART = 1.05  # the ranges must differ by this factor before a shift with range can be seen
BRIGHT = 0.05  # of a zone's peak: samples below carry no position


@dataclass(frozen=True)
class Baseline:
    """Position of the LiDAR in the camera's frame.

    origin_m: (3,) metres. sigma_m: (3,) standard error, from leaving out one zone at a time. rms: root mean square
    difference between the moved maps and the maps found at the other range, in fractions of each zone's peak.
    """

    origin_m: np.ndarray
    sigma_m: np.ndarray
    rms: float

    @property
    def lidar_from_camera(self) -> np.ndarray:
        """(4, 4) transform into a frame at the LiDAR with the camera's axes."""
        transform = np.eye(4)
        transform[:3, 3] = -self.origin_m
        return transform


def estimate_baseline(
    a: ResponseMaps,
    b: ResponseMaps,
    intrinsics: np.ndarray,
    depths_m: tuple[float, float],
    radii_px: tuple[float, float],
    progress: Progress = silent,
) -> Baseline:
    """Find the LiDAR's position from two scans whose patch moved in planes at two distances.

    The rays of `a`, carried from the camera's origin to the LiDAR's, must meet the second plane where `b` responds
    alike: least squares over the position, each zone's level free. Parallax moves a map by f · b · (1/Z_b − 1/Z_a).
    Across the optical axis this is sharp; along it, a tilt of either plane that is not known goes into the answer.

    intrinsics: (3, 3) of the full-size image, pixels. depths_m: of the two planes along the optical axis. radii_px: of
    the patch's image in each. Raises `Refusal` where the distances are no positive numbers or too alike, or the zones
    of the two differ.
    """
    if not all(np.isfinite(depth) and depth > 0 for depth in depths_m):
        raise Refusal(f"distances: {depths_m[0]} m and {depths_m[1]} m, expected metres above 0")
    if not (np.isfinite(intrinsics).all() and intrinsics[0, 0] > 0 and intrinsics[1, 1] > 0):
        focal = f"{intrinsics[0, 0]} and {intrinsics[1, 1]} px"
        raise Refusal(f"intrinsics: focal lengths {focal}, expected pixels above 0")
    ratio = max(depths_m) / min(depths_m)
    if ratio < APART:
        raise Refusal(
            f"distances: {depths_m[0]} m and {depths_m[1]} m, expected them to differ by a factor {APART} or more"
        )
    if a.zone_grid != b.zone_grid:
        raise Refusal(f"zones: {a.zone_grid} in the first and {b.zone_grid} in the second, expected the same grid")
    kernel_a, kernel_b = fit_kernel(a, radii_px[0]), fit_kernel(b, radii_px[1])
    problem = _Problem(a, kernel_a.density(a.xs, a.ys), kernel_b, intrinsics, depths_m)
    zones = np.arange(len(a.by_zone))
    start = problem.rough_origin(b)
    best, rms = problem.solve(zones, start)
    return Baseline(best, _jackknife(problem, zones, best, progress), rms)


def _jackknife(problem: "_Problem", zones: np.ndarray, best: np.ndarray, progress: Progress) -> np.ndarray:
    """(3,) standard error from leaving out zones: samples of one zone share their kernel's errors."""
    n = len(zones)
    if n == 1:
        return np.full(3, np.inf)
    left_out = progress(zones, n, "leaving out one zone at a time")
    without = np.stack([problem.solve(np.delete(zones, p), best)[0] for p in left_out])
    return np.sqrt((n - 1) / n * np.square(without - best).sum(axis=0))


@dataclass(frozen=True, eq=False)
class _Problem:
    """The samples of one scan, freed of the patch, and the kernel of the other that they are held against."""

    a: ResponseMaps
    density_a: np.ndarray
    kernel_b: Kernel
    intrinsics: np.ndarray
    depths_m: tuple[float, float]

    def geometry(self, origin: np.ndarray, depth_m: float) -> ScanGeometry:
        transform = np.eye(4)
        transform[:3, 3] = -origin
        return ScanGeometry(self.intrinsics, transform, depth_m)

    def rough_origin(self, b: ResponseMaps) -> np.ndarray:
        """A first guess: how far the centroids of all zones moved, read as parallax."""
        xy_a, xy_b = (np.stack([m.xs, m.ys], axis=1).astype(float) for m in (self.a, b))
        moved = np.median(centroids(_bright(b), xy_b) - centroids(_bright(self.a), xy_a), axis=0)
        per_metre = np.diag(self.intrinsics)[:2] * (1 / self.depths_m[1] - 1 / self.depths_m[0])
        return np.array([*(moved / per_metre), 0.0])

    def residuals(self, origin: np.ndarray, zones: np.ndarray) -> np.ndarray:
        here, there = (self.geometry(origin, depth) for depth in self.depths_m)
        x, y = self.a.xs.astype(float), self.a.ys.astype(float)
        points = here.points(x, y)
        moved = there.pixels(points)
        ranges = np.linalg.norm(points, axis=1), np.linalg.norm(there.points(*moved.T), axis=1)
        # Densities, since the patch covers more of the image at the nearer plane.
        expected = self.density_a[zones] * (ranges[0] / ranges[1]) ** FALLOFF
        found = self.kernel_b.density(*moved.T)[zones]
        inside = self.bright(expected) & self.kernel_b.basis.covers(*moved.T)
        found, expected = found * inside, expected * inside
        level = (found * expected).sum(axis=1, keepdims=True) / np.square(expected).sum(axis=1, keepdims=True)
        return ((found / level - expected) / expected.max(axis=1, keepdims=True)).ravel()

    @staticmethod
    def bright(expected: np.ndarray) -> np.ndarray:
        return expected > BRIGHT * expected.max(axis=1, keepdims=True)

    def solve(self, zones: np.ndarray, start: np.ndarray) -> tuple[np.ndarray, float]:
        """Origin of least squares, metres, and the root mean square that is left; searched in millimetres."""
        found = least_squares(lambda mm: self.residuals(mm * 1e-3, zones), start * 1e3, method="lm")
        return found.x * 1e-3, float(np.sqrt(np.mean(found.fun**2)))


def _bright(maps: ResponseMaps) -> np.ndarray:
    return np.where(maps.normalised > BRIGHT, maps.normalised, 0)

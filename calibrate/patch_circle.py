"""A circle through points of a rim, with a standard error that knows the noise along the rim is correlated."""

from dataclasses import dataclass

import numpy as np

RAYS = 96
_ANGLES = np.arange(RAYS) * (2 * np.pi / RAYS)
NORMALS = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], axis=1)
_DESIGN = np.column_stack([NORMALS, np.ones(RAYS)])

ROUNDS = 5
TUKEY = 4.685  # Tukey's biweight at 95 % efficiency.
CUT_PX = 0.5, 1.5  # A rim point further out than this belongs to something else, however rough the rim.
LEAST_RAYS = RAYS // 8
LEAST_NOISE_PX = 0.03
ALIKE = 20  # Glare and shadows move this many neighbouring points alike; a known radius weighs that much more.
FLOOR_PX = 0.012  # Rounding, interpolation and light that falls unevenly shift the whole rim, which no residual shows.


@dataclass(frozen=True)
class Expected:
    """What is known of a rim before one looks: its radius and how well, and how rough it is at least.

    noise_px: standard deviation per ray of departures from a circle, as `CircleFit.noise_px`.
    """

    radius_px: float
    radius_sigma_px: float = np.inf
    noise_px: float = 0.0


@dataclass(frozen=True)
class CircleFit:
    """A circle, relative to the point from which the rays start.

    dx_px, dy_px: its centre. radius_px. sigma_px: standard error of the centre along one axis, root mean square of
    the two. noise_px: standard deviation per ray of what moves the centre. inlier: (RAYS,) bool, rays whose point
    lies on the circle.
    """

    dx_px: float
    dy_px: float
    radius_px: float
    sigma_px: float
    noise_px: float
    inlier: np.ndarray


def fit_circle(
    distance_px: np.ndarray,
    usable: np.ndarray,
    visible: np.ndarray,
    cut_px: float,
    expected: Expected,
) -> CircleFit | None:
    """Fit a circle to a rim met at `distance_px` (RAYS,) along rays at equal angles; None where there is none.

    usable, visible: (RAYS,) bool, rays with a rim point, and rays along which the image could show one.
    cut_px: how far rim points may be from the first guess.

    Small displacements (dx, dy) of a circle change the distance along a ray with normal n by n · (dx, dy), so each
    round is a weighted linear fit; the start must be within a tenth of the radius for a bias below 0.01 px.
    """
    weight = usable.astype(float)
    solution = np.array([0.0, 0.0, expected.radius_px])
    cut = max(cut_px, CUT_PX[1])
    for _ in range(ROUNDS):
        error = distance_px - _DESIGN @ solution
        weight = np.where(usable, np.square(np.maximum(1 - np.square(error / cut), 0)), 0.0)
        inlier = weight > 0
        count = np.count_nonzero(inlier)
        if count < LEAST_RAYS:
            return None
        noise = max(1.4826 * float(np.partition(np.abs(error[inlier]), count // 2)[count // 2]), LEAST_NOISE_PX)
        stiffness = ALIKE * (noise / expected.radius_sigma_px) ** 2
        normal = (_DESIGN.T * weight) @ _DESIGN
        normal[2, 2] += stiffness
        right = (_DESIGN.T * weight) @ distance_px
        right[2] += stiffness * expected.radius_px
        # The ridge keeps a short arc without a prior solvable; it is 1e-8 of a rim's weight.
        solution = np.linalg.solve(normal + 1e-6 * np.eye(3), right)
        cut = float(np.clip(TUKEY * noise, max(CUT_PX[0], cut / 2), max(CUT_PX[1], cut / 2)))
    error = distance_px - _DESIGN @ solution
    squared = np.square(error / cut)[inlier]
    # Huber's sandwich: the fit responds to a displacement by the influence function's slope, not by its weight.
    slope = max(float(((1 - squared) * (1 - 5 * squared)).sum() / weight.sum()), 0.2)
    variance = max(_noise_power(weight * error, weight, visible) / slope**2, expected.noise_px**2)
    inverse = np.linalg.inv(normal + 1e-6 * np.eye(3))
    spread = variance * (_DESIGN.T * weight**2) @ _DESIGN
    if stiffness:
        spread[2, 2] += (stiffness * expected.radius_sigma_px) ** 2
    covariance = inverse @ spread @ inverse
    sigma = np.sqrt((covariance[0, 0] + covariance[1, 1]) / 2 + FLOOR_PX**2)
    return CircleFit(*(float(value) for value in solution), float(sigma), variance**0.5, weight > 0)


def _noise_power(error: np.ndarray, weight: np.ndarray, visible: np.ndarray) -> float:
    """Variance per ray that noise has where it moves a circle: at the lowest frequencies along the rim.

    Neighbouring rays share pixels, compression and the rim's own roughness, so the variance of the residuals is not
    it. The fit absorbs the first harmonics (more of them where less of the rim is seen); the next eight stand for
    these.
    """
    first = int(np.ceil(3 / visible.mean())) - 1
    power = np.square(np.abs(np.fft.rfft(error)[first : first + 8]))
    return float(power.mean() / np.square(weight).sum())

"""Steps of a fit: damped scoring within the bounds of the coordinates."""

import numpy as np
from scipy.linalg import LinAlgError, cho_factor, cho_solve
from scipy.sparse import csc_array
from scipy.sparse.linalg import spsolve

from mismatch.coordinate import bounds
from mismatch.form import Form
from mismatch.secant import MANY

# No light is that many times brighter or fainter than counts are few: beyond, numbers would overflow.
MOST_LOG_GAIN = 230.0
# Matrices of many numbers are asked first how much of them is filled, and solved as sparse below this part.
FILLED = 0.1


def bounded_step(gradient, curvature, damping, x, low, high) -> np.ndarray:
    """A damped scoring step; coordinates at a bound that pulls them out stay there."""
    held = ((x <= low) & (gradient < 0)) | ((x >= high) & (gradient > 0))
    step = np.zeros_like(x)
    scale = np.diag(curvature)
    for _ in range(len(x)):
        free = ~held
        if not free.any():
            return step
        matrix = curvature[np.ix_(free, free)]
        np.einsum("ii->i", matrix)[:] += damping * scale[free] + 1e-9 * max(scale.max(), 1e-30)
        step[:] = 0
        step[free] = solved(matrix, gradient[free])
        beyond = free & (((x <= low) & (step < 0)) | ((x >= high) & (step > 0)))
        if not beyond.any():
            return step
        held |= beyond
    return step


def solved(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """(N,) solution of a positive (N, N) matrix. Where each cell of a frame has its own number it is mostly nothing."""
    if len(right) > MANY:
        if np.count_nonzero(matrix) < FILLED * matrix.size:
            return spsolve(csc_array(matrix), right)
        try:
            return cho_solve(cho_factor(matrix, check_finite=False), right, check_finite=False)
        except LinAlgError:  # Positive but for rounding, which elimination bears.
            pass
    return np.linalg.solve(matrix, right)


def limits(forms: tuple[Form, ...]) -> tuple[np.ndarray, np.ndarray]:
    """(N,) each: bounds of the coordinates, log gain first."""
    pairs = [(-MOST_LOG_GAIN, MOST_LOG_GAIN)] + [
        bounds(parameter) for form in forms for parameter, _ in form.coordinates
    ]
    low, high = np.array(pairs).T
    return low, high

"""Photons are counted: Poisson counts around what is expected."""

import numpy as np

from recordings.refusal import Refusal

LARGEST = float(np.iinfo(np.uint32).max) / 2


def draw_counts(expected: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Independent Poisson counts, uint32, of the shape of `expected`.

    Raises `Refusal` where an expected count is negative, not finite or too large for the type.
    """
    expected = np.asarray(expected, float)
    good = (expected >= 0) & (expected < LARGEST)
    if not good.all():
        index = tuple(int(i) for i in np.unravel_index(np.argmin(good), expected.shape))
        raise Refusal(f"expected counts{list(index)} is {expected[index]}, expected 0 to {LARGEST:.3g}")
    return rng.poisson(expected).astype(np.uint32)

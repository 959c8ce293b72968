"""A response that is positive, sums to one and is as smooth as its coefficients: the logarithm is a spline."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import BSpline

# Steps from knot to knot where the pulse rises and falls, and how much further apart each is than the one before in its
# tail. Closer knots would let in structure of one bin's period, which bins integrate away and counts hardly see.
STEPS_PER_KNOT = 2
CORE_BINS = 4.0
STRETCH = 1.12
WIDEST_BINS = 3.0
# Third differences of the coefficients vanish for a parabola: what no data speak of becomes Gaussian.
ORDER = 3


@dataclass(frozen=True, eq=False)
class Shape:
    """Steps of a response, and splines over them.

    per_bin: steps to a bin. before: bins before the nominal arrival at which it begins. peak: bins after the nominal
    arrival, about, at which it is largest. after: bins at which it ends.
    """

    per_bin: int
    before: float
    peak: float
    after: float

    @cached_property
    def offsets(self) -> np.ndarray:
        """(N,) centre of each step, steps after the nominal arrival; whole numbers."""
        return np.arange(np.floor(-self.before * self.per_bin), np.ceil(self.after * self.per_bin) + 1)

    @cached_property
    def basis(self) -> np.ndarray:
        """(N, K) cubic B-splines: close knots up to some bins after the peak, wider and wider ones in the tail."""
        low, high = (self.offsets[[0, -1]] + np.array([-0.5, 0.5])) / self.per_bin
        width = closest = STEPS_PER_KNOT / self.per_bin
        knots = list(np.arange(low, min(self.peak + CORE_BINS, high), closest))
        while knots[-1] < high:
            width = min(width * STRETCH, WIDEST_BINS)
            knots.append(knots[-1] + width)
        knots = np.array(knots)
        outer = np.arange(1, 4)
        knots = np.concatenate([low - outer[::-1] * closest, knots, knots[-1] + outer * width])
        return BSpline.design_matrix(self.offsets / self.per_bin, knots, 3).toarray()

    @cached_property
    def roughness(self) -> np.ndarray:
        """(K, K) sum of the squared third differences of the coefficients (P-splines: Eilers & Marx 1996)."""
        differences = np.diff(np.eye(self.basis.shape[1]), n=ORDER, axis=0)
        return differences.T @ differences


def normalised(log: np.ndarray) -> np.ndarray:
    """(N,) probabilities of which `log` is the logarithm but for a constant."""
    values = np.exp(log - log.max())
    return values / values.sum()

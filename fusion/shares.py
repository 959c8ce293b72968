"""What part of each zone's view lies at which range: light, weighed by the square of range, without its noise."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.ndimage import uniform_filter1d

from fusion.zone_view import GOOD, ZoneDepths

# What is certain is asked of the light within so many metres: r² would make area of photon noise.
ABOUT_M = 0.2
# Steps of the logarithm of range: 3 %.
STEP = 0.03
NEAREST_M = 0.05


@dataclass(frozen=True, eq=False)
class Shares:
    """Distributions of area over the logarithm of range, for the Q zones that report any.

    zones: (Q,) which zones. log_m: (B,) logarithm of range in metres, evenly spaced. cumulative: (Q, B) part of the
    zone's area that is nearer, 0 to 1.
    """

    zones: np.ndarray
    log_m: np.ndarray
    cumulative: np.ndarray

    @cached_property
    def parts(self) -> np.ndarray:
        """(Q, B - 1) part of the area between each two ranges."""
        return np.diff(self.cumulative, axis=1)

    @cached_property
    def mean(self) -> np.ndarray:
        """(Q,) mean logarithm of range."""
        return self.parts @ self._middle

    @cached_property
    def spread(self) -> np.ndarray:
        """(Q,) standard deviation of the logarithm of range."""
        return np.sqrt(np.maximum(self.parts @ self._middle**2 - self.mean**2, 0))

    @cached_property
    def _middle(self) -> np.ndarray:
        return (self.log_m[1:] + self.log_m[:-1]) / 2


def shares(depths: ZoneDepths, certain: float) -> Shares:
    """The distributions of one frame, with depths (P,) of its zones.

    certain: how many standard errors of background light must exceed to count.
    Light of equal areas of one reflectance falls with r² (the nominal model), so area is light · r².
    """
    light = _above_noise(depths, certain)
    # Light is of a range and of what lies about it, half way to its neighbours.
    between = (depths.range_m[1:] + depths.range_m[:-1]) / 2
    edges = np.concatenate(([1.5 * depths.range_m[0] - 0.5 * between[0]], between, [depths.range_m[-1]]))
    edges = np.maximum.accumulate(np.maximum(edges, NEAREST_M))
    area = light * depths.range_m**2
    total = area.sum(axis=1)
    zones = np.flatnonzero((total > 0) & (depths.state == GOOD) & np.isfinite(depths.surface_m).any(axis=1))
    log_m = np.arange(np.log(edges[0]) - STEP, np.log(edges[-1]) + 2 * STEP, STEP)
    summed = np.concatenate([np.zeros((len(zones), 1)), np.cumsum(area[zones], axis=1)], axis=1)
    summed /= total[zones, None]
    table = np.array([np.interp(np.exp(log_m), edges, one) for one in summed]).reshape(len(zones), len(log_m))
    return Shares(zones, log_m, table)


def _above_noise(depths: ZoneDepths, certain: float) -> np.ndarray:
    """(P, B) light, 0 where background alone may have made what is found there."""
    step = float(np.median(np.diff(depths.range_m)))
    near = max(1, round(ABOUT_M / step))
    around = uniform_filter1d(depths.light, near, axis=1, mode="constant") * near
    # Entries are half a bin apart. One count is added where there is no background: it came from somewhere.
    dark = depths.level[:, None] * near / 2 + 1
    return np.where(around > certain * np.sqrt(dark), depths.light, 0.0)

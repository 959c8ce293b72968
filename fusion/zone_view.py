"""What zones see: a few surfaces each, with errors, and the light they were found in."""

from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np

GOOD, DEAD, SATURATED = 0, 1, 2


@dataclass(frozen=True, eq=False)
class ZoneDepths:
    """What P zones see, in one frame (no axis F) or in F frames.

    range_m: (B,) metres. light: (F, P, B) units of `RangeResponse` that came from each range. level: (F, P) flat counts
    per bin. surface_m: (F, P, S) mean range of the light of each surface, brightest first, NaN where there are fewer.
    surface_counts, surface_sigma_m, surface_spread_m: (F, P, S) its counts, standard error of its range by photon noise
    (Fisher's information, all surfaces and the level unknown), and standard deviation of ranges within it.
    nothing: (F, P) probability that nothing is there, at even odds. state: (F, P) uint8: 0 good, 1 dead, 2 saturated;
    a zone that is not good has no surface.
    """

    range_m: np.ndarray
    light: np.ndarray
    level: np.ndarray
    surface_m: np.ndarray
    surface_counts: np.ndarray
    surface_sigma_m: np.ndarray
    surface_spread_m: np.ndarray
    nothing: np.ndarray
    state: np.ndarray

    @cached_property
    def area(self) -> np.ndarray:
        """(F, P, S) how much of the zone's view each surface fills, sums to 1; NaN where there is none.

        For one reflectance: light of equal areas falls with r². What the response holds of that is in the counts.
        """
        share = self.surface_counts * self.surface_m**2
        total = np.nansum(share, axis=-1, keepdims=True)
        return np.where(total > 0, share / np.where(total > 0, total, 1), np.nan)

    @cached_property
    def mean_m(self) -> np.ndarray:
        """(F, P) mean range by area over all surfaces, NaN where there is none."""
        seen = np.isfinite(self.surface_m).any(axis=-1)
        return np.where(seen, np.nansum(self.area * self.surface_m, axis=-1), np.nan)

    @property
    def typical_m(self) -> float:
        """Geometric mean of the zones' mean ranges, NaN where there is none."""
        known = np.isfinite(self.mean_m) & (self.mean_m > 0)
        return float(np.exp(np.log(self.mean_m[known]).mean())) if known.any() else np.nan

    @cached_property
    def deviation_m(self) -> np.ndarray:
        """(F, P) standard deviation of the range of a point somewhere in the zone: surfaces, spreads and errors."""
        about = (self.surface_m - self.mean_m[..., None]) ** 2 + self.surface_spread_m**2 + self.surface_sigma_m**2
        return np.where(np.isfinite(self.mean_m), np.sqrt(np.nansum(self.area * about, axis=-1)), np.nan)

    def frame(self, i: int) -> "ZoneDepths":
        """Frame `i` alone, without the axis F."""
        names = [field.name for field in fields(self) if field.name != "range_m"]
        return replace(self, **{name: getattr(self, name)[i] for name in names})

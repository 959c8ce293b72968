"""Maps of all zones as the sensor's optics would have them, with what is uncertain about these as unknowns."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from calibrate.adaptive_optics import SIZE, SPREAD, SpadOptics
from calibrate.spline import SplineBasis

FLOOD_STEP = 4.2  # knots of the flood's departure from its nominal shape, patch radii apart
FLOOD_SPREAD = 0.25
GAIN_SPREAD = 0.2  # of the logarithm
STRAY, STRAY_SPREAD = 0.01, 0.03
HALO, HALO_SPREAD = 0.05, 0.05
WEIGHT_SPREAD = (0.15, 0.1, 0.06)  # of the SPADs of a row, of a zone's part of a row, of one SPAD
SEEN = 0.02  # of the peak: where less than this is expected, a response is stray light


@dataclass(frozen=True, eq=False)
class Rows:
    """Responses of some zones at some points, in units of each zone's scale.

    zone, cell: (N,) which. value, near: (N,) as modelled, and at most so whatever the details. Their
    slopes: by the unknowns, slope (N, M), sparse; by the place, tilt (N, 2), per pixel.
    """

    zone: np.ndarray
    cell: np.ndarray
    value: np.ndarray
    near: np.ndarray
    slope: sparse.csr_array
    tilt: np.ndarray


@dataclass(frozen=True, eq=False)
class Model:
    """R = gain · optics · (1 + the flood's departure) + halo · blurred + stray · sum of all zones blurred.

    The unknowns are, in this order: the optics' parameters, the weights of SPADs, logarithms of the zones' gains, the
    shares of light scattered nearby and anywhere, and coefficients of the flood's departure.
    """

    optics: SpadOptics
    flood: SplineBasis
    zones: int

    @property
    def start(self) -> tuple[int, int, int]:
        """Where the gains, the scattered light and the flood begin in the unknowns."""
        gains = SIZE + self.optics.mixing.shape[1]
        return gains, gains + self.zones, gains + self.zones + 2

    @property
    def spread(self) -> np.ndarray:
        """(M,) prior standard deviations of the unknowns."""
        weights = np.repeat(WEIGHT_SPREAD, self.optics.weights)
        rest = [[GAIN_SPREAD] * self.zones, [HALO_SPREAD, STRAY_SPREAD], [FLOOD_SPREAD] * self.flood.size]
        return np.concatenate([SPREAD, weights, *rest])

    def nominal(self, values: np.ndarray, gains: np.ndarray) -> np.ndarray:
        """(M,) the unknowns of a device with these parameters of its optics (18,) and gains (P,)."""
        weights = np.zeros(self.optics.mixing.shape[1])
        return np.concatenate([values, weights, np.log(gains), [HALO, STRAY], np.zeros(self.flood.size)])

    def maps(self, unknown: np.ndarray, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(P, N) responses and what they are at most, whatever the details of the optics."""
        gains, stray, flood = self.start
        gain, (halo, far) = np.exp(unknown[gains:stray])[:, None], unknown[stray:flood]
        factor = 1 + self.flood.at(x, y) @ unknown[flood:]
        near = gain * self.optics.envelope(unknown[:gains], x, y)
        core = gain * self.optics.maps(unknown[:gains], x, y) * factor
        return core + halo * near + far * near.sum(axis=0), near

    def rows(self, unknown: np.ndarray, x: np.ndarray, y: np.ndarray, kept: np.ndarray) -> Rows:
        """What is modelled of those zones and points that `kept` (P, N) names."""
        gains, stray, flood = self.start
        values, gain = unknown[:gains], np.exp(unknown[gains:stray])
        base, by_value = self.optics.derivatives(values, x, y)
        by_weight = self.optics.by_weight(values, x, y)
        splines = self.flood.at(x, y)
        factor = 1 + splines @ unknown[flood:]
        value, near = self.maps(unknown, x, y)
        blocks = []
        for p in range(self.zones):
            at = np.flatnonzero(kept[p])
            scale = gain[p] * factor[at]
            common = np.zeros((len(at), self.zones + 2))
            common[:, p] = base[p, at] * scale + unknown[stray] * near[p, at]
            common[:, -2] = near[p, at]
            common[:, -1] = near[:, at].sum(axis=0)
            blocks.append(
                sparse.hstack(
                    [
                        sparse.csr_array((by_value[:, p, at] * scale).T),
                        sparse.diags_array(scale) @ by_weight[p][at],
                        sparse.csr_array(common),
                        sparse.diags_array(gain[p] * base[p, at]) @ splines[at],
                    ]
                )
            )
        zone, cell = np.nonzero(kept)
        slope = sparse.csr_array(sparse.vstack(blocks))
        return Rows(zone, cell, value[kept], near[kept], slope, self._tilt(unknown, x, y)[kept])

    def _tilt(self, unknown: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """(P, N, 2) how the maps change per pixel along x and y."""
        ends = [self.maps(unknown, x + dx, y + dy)[0] for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1))]
        return np.stack([ends[0] - ends[1], ends[2] - ends[3]], axis=-1) / 2

"""Two calibrations of one sensor at the positions they share, with their noise and the division that judges."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from calibrate.consistency import common_positions
from calibrate.kernel import Kernel, fit_kernel
from mismatch.calibrations.noise import local_scatter
from recordings.maps import ResponseMaps
from recordings.refusal import Refusal

TILE = (
    4.0  # scan steps along the side of a tile: a SPAD's image, 2.5 × 6 steps in the published scans, lies mostly in one
)
LEAST_TILES = 16


@dataclass(frozen=True, eq=False)
class Pair:
    """P zones at K scan positions that both calibrations have.

    a, b: (P, K) counts. noise: (P, K) counts of b, standard deviation of b around what a's sample and a gain say.
    xy: (K, 2) pixels. along: (K, 2) pixels from each capture to the next. when: (K,) -0.5 to 0.5 over the scan.
    tile: (K,) number of the tile. held: (K,) true where the position takes no part in choosing or fitting.
    kernel: the first calibration between its samples. size: width and height of the image. unit: counts of b per a.
    """

    a: np.ndarray
    b: np.ndarray
    noise: np.ndarray
    xy: np.ndarray
    along: np.ndarray
    when: np.ndarray
    tile: np.ndarray
    held: np.ndarray
    kernel: Kernel
    size: tuple[int, int]
    unit: float

    def of(self, where: np.ndarray) -> "Pair":
        """At some positions only."""
        names = ("xy", "along", "when", "tile", "held")
        zones = {name: getattr(self, name)[:, where] for name in ("a", "b", "noise")}
        return replace(self, **zones, **{name: getattr(self, name)[where] for name in names})

    def moved(self, light: np.ndarray, shift: np.ndarray) -> np.ndarray:
        """(P, K) the first calibration displaced by `shift`, (K, 2) or (2,) pixels.

        What the kernel changes is added to the samples, so that their own fine structure stays.
        """
        there = self.kernel.response(*(self.xy - shift).T)
        return np.maximum(light + there - self.kernel.response(*self.xy.T), 0)


def pair(a: ResponseMaps, b: ResponseMaps) -> Pair:
    """The captures both have, divided into a checkerboard of tiles: one colour chooses and fits, the other judges.

    Neighbouring samples share the light of one SPAD; whole tiles are held out so that they cannot judge each other.
    """
    first, second = common_positions(a, b)
    xy = np.stack([a.xs, a.ys], axis=1)[first].astype(float)
    seen = [m.by_zone[:, i].astype(float) for m, i in ((a, first), (b, second))]
    for values, which in zip(seen, ("first", "second"), strict=True):
        if dead := np.flatnonzero(values.max(axis=1) <= 0).tolist():
            raise Refusal(f"responses: zones {dead} of the {which} calibration never respond, expected a peak above 0")
    step = float(np.median(cKDTree(xy).query(xy, 2)[0][:, 1]))
    if not step > 0:
        raise Refusal(f"xs, ys: median distance of neighbours {step} px, expected scan positions that differ")
    cell = np.floor((xy - xy.min(axis=0)) / (TILE * step)).astype(int)
    tile = np.unique(cell, axis=0, return_inverse=True)[1].ravel()
    if tile.max() + 1 < LEAST_TILES:
        raise Refusal(f"xs, ys: {len(xy)} common positions lie in {tile.max() + 1} tiles of {TILE:.0f} × {TILE:.0f} "
                      f"scan steps, expected at least {LEAST_TILES} to hold half of them out")  # fmt: skip
    unit = float(np.median(seen[1].max(axis=1) / seen[0].max(axis=1)))
    along = np.gradient(xy, axis=0)
    along[np.hypot(*along.T) > 3 * step] = 0  # between rows of a scan that is no snake
    return Pair(
        seen[0], seen[1], _noise(xy, seen), xy, along, np.linspace(-0.5, 0.5, len(xy)),
        tile, cell.sum(axis=1) % 2 == 1, fit_kernel(a, 0.0, first), a.image_size, unit,
    )  # fmt: skip


def _noise(xy: np.ndarray, seen: list[np.ndarray]) -> np.ndarray:
    """Of both calibrations together, in counts of the second; the first is weighed by the gain between their peaks."""
    peaks = [values.max(axis=1, keepdims=True) for values in seen]
    scatter = [local_scatter(xy, values) for values in seen]
    return np.sqrt((peaks[1] / peaks[0] * scatter[0]) ** 2 + scatter[1] ** 2 + (1e-6 * peaks[1]) ** 2)

"""Figures that judge: consistency on held-out positions, misfit, and where it sits."""

import numpy as np
from scipy.stats import t as student

from calibrate.consistency import centroids, cosines, support_iou
from mismatch.calibrations.fitting import Fitted
from mismatch.calibrations.pair import Pair
from mismatch.calibrations.verdict import Figures, Where

THRESHOLDS = (0.05, 0.1, 0.2, 0.3, 0.5)
MOST = 100.0  # squared difference that one sample may count, so that single captures gone wrong do not decide
MISFIT = 1.5  # mean squared difference that stands above noise: the scatter is itself known to some tens of per cent
HELD = 0.8


def figures(pair: Pair, a: np.ndarray, b: np.ndarray, held: np.ndarray) -> Figures:
    """Consistency of (P, K) maps at the positions `held`, peaks taken from all positions, as published."""
    map_a, map_b = (m[:, held] / m.max(axis=1, keepdims=True) for m in (a, b))
    apart = centroids(map_a, pair.xy[held]) - centroids(map_b, pair.xy[held])
    return Figures(
        displacement_px=float(np.hypot(*apart.T).mean()),
        one_minus_cosine=float(1 - cosines(map_a, map_b).mean()),
        thresholds=THRESHOLDS,
        iou=tuple(float(support_iou(map_a, map_b, level).mean()) for level in THRESHOLDS),
    )


def floor(pair: Pair, held: np.ndarray, rng: np.random.Generator) -> Figures:
    """What the scatter of samples around their neighbours leaves of the agreement of a map with itself."""
    noisy = np.maximum(pair.b + pair.noise * rng.standard_normal(pair.b.shape), 0)
    return figures(pair, noisy, pair.b, held)


def squared(pair: Pair, fitted: Fitted) -> np.ndarray:
    """(P, K) squared difference in units of the noise alone."""
    return np.minimum(fitted.residual(pair, 0.0) ** 2, MOST)


def misfits(pair: Pair, fitted: Fitted, significant: float) -> bool:
    """Whether what is left stands above the noise, by the scatter from tile to tile."""
    tile = np.unique(pair.tile, return_inverse=True)[1]
    each = np.bincount(tile, squared(pair, fitted).mean(axis=0)) / np.bincount(tile)
    error = each.std(ddof=1) / np.sqrt(len(each))
    return bool(each.mean() > MISFIT and student.sf((each.mean() - 1) / max(error, 1e-12), len(each) - 1) < significant)


def places(pair: Pair, fitted: Fitted) -> tuple[Where, ...]:
    """Zone by zone, where the difference sits, the largest share first."""
    off = (pair.b - fitted.predicted(pair)) / pair.b.max(axis=1, keepdims=True)
    energy = np.minimum(off**2, np.quantile(off**2, 0.9995))
    found = []
    for zone in range(len(off)):
        share = float(energy[zone].sum() / max(energy.sum(), 1e-300))
        x, y = (_extent(pair.xy[:, axis], energy[zone]) for axis in (0, 1))
        sentence = (
            f"zone {zone}, x {x[0]:.0f} to {x[1]:.0f} px, y {y[0]:.0f} to {y[1]:.0f} px: "
            f"{100 * share:.0f} % of the squared difference of the peak-normalised maps"
        )
        found.append(Where((zone,), (*x, *y), share, sentence))
    return tuple(sorted(found, key=lambda place: -place.share))


def _extent(at: np.ndarray, energy: np.ndarray) -> tuple[float, float]:
    """The middle of an axis that holds most of the energy."""
    order = np.argsort(at)
    until = np.cumsum(energy[order]) / max(energy.sum(), 1e-300)
    ends = np.searchsorted(until, ((1 - HELD) / 2, (1 + HELD) / 2))
    low, high = at[order][np.minimum(ends, len(at) - 1)]
    return float(low), float(high)

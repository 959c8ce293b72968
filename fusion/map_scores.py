"""How well predicted histograms agree with recorded ones, when much of the model is not to be relied on."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.optimize import nnls

# What a model of a real scene is off by, choices: of a bin's counts, for albedo within a surface and the pulse's shape,
# and of the histogram's peak, for light that came by other ways.
MODEL_ERROR, MODEL_FLOOR = 0.15, 0.02
# A histogram that fits badly for reasons of its own must not outvote the others: Student's t of so many degrees.
DEGREES = 10.0
# The pulse may come so many bins earlier, and so many later, than the sensor model says.
EARLIER, LATER = 2, 6


def precision(counts: np.ndarray) -> np.ndarray:
    """(..., T) one over the variance of counts: of photons, and of the model."""
    level = uniform_filter1d(counts, 3, axis=-1)
    peak = counts.max(axis=-1, keepdims=True)
    return 1 / (level + 1 + (MODEL_ERROR * level) ** 2 + (MODEL_FLOOR * peak) ** 2)


def misfit(counts: np.ndarray, weights: np.ndarray, signal: np.ndarray) -> np.ndarray:
    """(...) χ² of counts about a·signal + b with a ≥ 0 and b at their best: brightness and pedestal are free.

    All (..., T), or what broadcasts to it. By the weighted normal equations of a line.
    """
    one, n, s = weights.sum(-1), (weights * counts).sum(-1), (weights * signal).sum(-1)
    nn = (weights * counts**2).sum(-1) - n * n / one
    ss = np.einsum("...t,...t,...t->...", weights, signal, signal)
    sn = np.einsum("...t,...t,...t->...", weights, counts, signal) - s * n / one
    return _left(nn, ss, s * s / one, sn)


def _left(nn: np.ndarray, ss: np.ndarray, mean: np.ndarray, sn: np.ndarray) -> np.ndarray:
    """What a line leaves of a sum of squares nn. ss: of the signal, `mean` of it its mean's; sn: signal with counts."""
    spread = ss - mean
    explained = np.where(spread > 1e-6 * ss, np.maximum(sn, 0) ** 2 / np.where(spread > 0, spread, 1), 0)
    return np.maximum(nn - explained, 0)


@dataclass(frozen=True, eq=False)
class Candidates:
    """Signals to compare with recorded counts, for many recordings of one scene.

    signals, squares: (F, P, C, T) float32 counts, and counts squared.
    """

    signals: np.ndarray
    squares: np.ndarray

    @classmethod
    def of(cls, signals: np.ndarray) -> "Candidates":
        """From signals (F, P, C, T)."""
        single = np.ascontiguousarray(signals, np.float32)
        return cls(single, single**2)

    def misfit(self, counts: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """(F, P, C) χ² as `misfit` finds it, of counts and weights (F, P, T)."""
        one, n = weights.sum(-1)[..., None], (weights * counts).sum(-1)[..., None]
        nn = (weights * counts**2).sum(-1)[..., None] - n * n / one
        with_counts = np.stack([weights, weights * counts], axis=-1).astype(np.float32)
        s, sn = np.moveaxis(self.signals @ with_counts, -1, 0).astype(float)
        ss = (self.squares @ with_counts[..., :1])[..., 0].astype(float)
        return _left(nn, ss, s * s / one, sn - s * n / one)

    def score(self, counts: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """(F, P, C) log-likelihood of each histogram but for a constant, heavy-tailed."""
        # What photons alone make of χ² is no misfit: about 1 in every bin where they, not the model, rule the variance.
        by_photons = (weights * uniform_filter1d(counts, 3, axis=-1)).sum(-1)[..., None]
        degrees = DEGREES + 2 * np.sqrt(2 * by_photons)
        excess = np.maximum(self.misfit(counts, weights) - by_photons, -degrees / 2)
        return -0.5 * degrees * np.log1p(excess / degrees)


def pulse_correction(counts: np.ndarray, weights: np.ndarray, signal: np.ndarray) -> np.ndarray:
    """(EARLIER + 1 + LATER,) what to convolve signals with so that they fit best, ≥ 0 with sum 1; one for all zones.

    It takes up what is wrong with time zero, the pulse's width and its tail. All arguments (F, P, T).
    """
    lags = np.arange(-EARLIER, LATER + 1)
    scale = np.sqrt(weights)
    # Brightness is that of the uncorrected fit; histograms then weigh as their counts allow.
    level = np.median(counts, axis=-1, keepdims=True)
    above, used = counts - level, weights > 0
    bright = (above * used).sum(-1, keepdims=True) / np.maximum((signal * used).sum(-1, keepdims=True), 1e-300)
    bright = np.maximum(bright, 0)
    columns = [(scale * bright * _late(signal, lag)).ravel() for lag in lags]
    found, _ = nnls(np.stack(columns, axis=1), (scale * above).ravel())
    nothing = (lags == 0).astype(float)
    return found / found.sum() if found.sum() > 0 else nothing


def corrected(signal: np.ndarray, kernel: np.ndarray) -> np.ndarray:
    """(..., T) signal through the correction."""
    lags = range(-EARLIER, LATER + 1)
    return sum(float(share) * _late(signal, lag) for share, lag in zip(kernel, lags, strict=True) if share > 0)


def delayed(signal: np.ndarray, bins: np.ndarray | float) -> np.ndarray:
    """(..., T) signal later by parts of a bin, or bins; `bins` is of any shape that (...) has or that spreads to it.

    By Lagrange's cubic through four bins (Laakso et al. 1996, IEEE Signal Processing Magazine 13, 30).
    """
    bins = np.broadcast_to(np.asarray(bins, float), signal.shape[:-1])
    whole = np.floor(bins)
    x = (bins - whole)[..., None].astype(signal.dtype)
    taps = (
        -x * (x - 1) * (x - 2) / 6,
        (x + 1) * (x - 1) * (x - 2) / 2,
        -(x + 1) * x * (x - 2) / 2,
        (x + 1) * x * (x - 1) / 6,
    )
    out = np.zeros_like(signal)
    for n in np.unique(whole):
        here = whole == n
        part = signal[here]
        # The tap for -x is the sample one bin before.
        out[here] = sum(tap[here] * _late(part, int(n) + k - 1) for k, tap in enumerate(taps))
    return np.maximum(out, 0)


def _late(signal: np.ndarray, bins: int) -> np.ndarray:
    """Signal later by whole bins."""
    out, length = np.zeros_like(signal), signal.shape[-1]
    if bins >= 0:
        out[..., bins:] = signal[..., : length - bins]
    else:
        out[..., :bins] = signal[..., -bins:]
    return out

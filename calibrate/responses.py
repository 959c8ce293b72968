"""From histograms with and without the patch to one response per zone and position (Behari & Raskar 2026, Eq. 2)."""

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri

from calibrate.window import Window

BRIGHT = 10.0  # responses this many photon-noise errors high tell of gain noise
CHANCE = 1e-3  # how often noise alone exceeds the noise limit


@dataclass(frozen=True)
class Responses:
    """Responses of P zones at K positions.

    value: (P, K) counts, R_p(u_k) = max over t in G of [τ_p,k(t) − τ_bg_p,k(t)]₊, mean over repeats.
    sigma: (P, K) counts, standard error: photon statistics of both captures, and the scatter of repeats.
    peak_bin: (P, K) bin in which the maximum was found.
    noise_limit: (P, K) counts, what the maximum over G exceeds without a patch once in a thousand captures.
    gain_noise: fraction by which repeats of a capture scatter beyond photon statistics; 0 where there are none.
    """

    value: np.ndarray
    sigma: np.ndarray
    peak_bin: np.ndarray
    noise_limit: np.ndarray
    gain_noise: float


def responses(
    counts: np.ndarray, background: np.ndarray | None, window: Window, frames: np.ndarray | None = None
) -> Responses:
    """Background-subtracted peak inside the window, with its standard error.

    counts, background: (F, P, T) photon counts with and without the patch, frame by frame; without background
    nothing is subtracted. frames: (K, repeats) frame indices of each position; every frame is one where None.
    """
    frames = np.arange(len(counts))[:, None] if frames is None else frames
    repeats = frames.shape[1]
    lit = _inside(counts, window, frames)
    dark = np.zeros_like(lit) if background is None else _inside(background, window, frames)

    # (K, repeats, P, G); one repeat is the published case and takes no mean.
    mean_lit, mean_dark = (lit[:, 0], dark[:, 0]) if repeats == 1 else (lit.mean(axis=1), dark.mean(axis=1))
    difference = mean_lit - mean_dark
    peak = difference.argmax(axis=2)[:, :, None]
    value = np.maximum(np.take_along_axis(difference, peak, axis=2)[:, :, 0], 0)
    photons = np.take_along_axis(mean_lit, peak, axis=2)[:, :, 0] + np.take_along_axis(mean_dark, peak, axis=2)[:, :, 0]
    # A count of 0 still allows for a mean of about 1: an error is never 0.
    variance = np.maximum(photons, 1).astype(float)
    gain_noise = _gain_noise(lit - dark, peak, value, variance) if repeats > 1 else 0.0
    return Responses(
        value=value.T.astype(float),
        sigma=np.sqrt((variance + (gain_noise * value) ** 2) / repeats).T,
        peak_bin=peak[:, :, 0].T + window.first,
        noise_limit=_noise_limit(mean_lit, None if background is None else mean_dark, repeats).T,
        gain_noise=gain_noise,
    )


def _inside(counts: np.ndarray, window: Window, frames: np.ndarray) -> np.ndarray:
    """(K, repeats, P, G) counts inside the window in a signed type that holds sums and differences exactly."""
    cut = counts[:, :, window.first : window.last + 1]
    if not np.array_equal(frames.ravel(), np.arange(len(counts))):
        cut = cut[frames.ravel()]
    # Where the counts fit, 32 bits halve the memory traffic of all that follows.
    fits = cut.dtype.itemsize < 4 or cut.max(initial=0) < 2**30
    return cut.astype(np.int32 if fits else np.int64).reshape(*frames.shape, *cut.shape[1:])


def _gain_noise(difference: np.ndarray, peak: np.ndarray, value: np.ndarray, variance: np.ndarray) -> float:
    """Relative standard deviation between repeats beyond photon statistics, pooled over all bright responses.

    difference: (K, repeats, P, G). Moment estimate: Σ(s² − photon variance) = g² Σ R².
    """
    at_peak = np.take_along_axis(difference, peak[:, None], axis=3)[..., 0]
    bright = value > BRIGHT * np.sqrt(variance)
    excess = (at_peak.var(axis=1, ddof=1) - variance)[bright].sum()
    return float(np.sqrt(max(excess, 0) / np.square(value[bright]).sum())) if bright.any() else 0.0


def _noise_limit(lit: np.ndarray, dark: np.ndarray | None, repeats: int) -> np.ndarray:
    """(K, P) level that the largest of G noise values exceeds with probability `CHANCE`.

    Normal quantile of the maximum of G independent values, with the variance of the noisiest bin: an upper bound.
    Without a background scan the pedestal, here the median bin, stays in the response and in its limit.
    """
    quantile = ndtri((1 - CHANCE) ** (1 / lit.shape[2]))
    if dark is None:
        pedestal = np.median(lit, axis=2)
        return pedestal + quantile * np.sqrt(np.maximum(pedestal, 1) / repeats)
    return quantile * np.sqrt(2.0 * np.maximum(dark.max(axis=2), 1) / repeats)

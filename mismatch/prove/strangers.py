"""Causes that are not in the library: what the tool must call unknown.

Each takes the expected counts (F, P, T) of an undisturbed recording and gives those with the cause at a strength.
"""

from collections.abc import Callable

import numpy as np
from scipy.ndimage import gaussian_filter1d, shift

Stranger = Callable[[np.ndarray, float, np.random.Generator], np.ndarray]


def warming_pulse(expected: np.ndarray, strength: float, rng: np.random.Generator) -> np.ndarray:
    """Pulses grow wider in the course of the session."""
    sigmas = strength * np.linspace(0, 1, len(expected))
    return np.stack([gaussian_filter1d(frame, s, axis=-1, mode="nearest") if s > 0 else frame
                     for frame, s in zip(expected, sigmas, strict=True)])  # fmt: skip


def every_other_pulse(expected: np.ndarray, strength: float, rng: np.random.Generator) -> np.ndarray:
    """The pulse is wider in every other frame."""
    out = expected.copy()
    out[1::2] = gaussian_filter1d(expected[1::2], strength, axis=-1, mode="nearest")
    return out


def leak_to_next_zone(expected: np.ndarray, strength: float, rng: np.random.Generator) -> np.ndarray:
    """The wire of one zone is heard in another, some bins later."""
    one, other = rng.choice(expected.shape[1], 2, replace=False)
    out = expected.copy()
    heard = np.roll(expected[:, one], rng.integers(5, 15), axis=-1)
    out[:, other] += strength * (heard - heard.min(axis=-1, keepdims=True))
    return out


def blinking_zone(expected: np.ndarray, strength: float, rng: np.random.Generator) -> np.ndarray:
    """One zone loses part of its counts in every fifth frame."""
    out = expected.copy()
    out[::5, rng.integers(expected.shape[1])] *= max(0.0, 1 - strength)
    return out


def hum(expected: np.ndarray, strength: float, rng: np.random.Generator) -> np.ndarray:
    """The mains are heard in the dark counts: a wave over their bins, later in each frame than in the one before."""
    frame, bins = np.arange(len(expected))[:, None], np.arange(expected.shape[-1])
    wave = np.sin(2 * np.pi * (bins / rng.uniform(20, 60) + frame * rng.uniform(0.1, 0.4)))
    return expected + np.clip(strength, 0, 1) * expected.min(axis=-1, keepdims=True) * wave[:, None, :]


def trembling_clock(expected: np.ndarray, strength: float, rng: np.random.Generator) -> np.ndarray:
    """Time zero of all zones jumps from frame to frame."""
    jumps = strength * rng.normal(size=len(expected))
    return np.stack([shift(frame, (0, j), order=1, mode="nearest") for frame, j in zip(expected, jumps, strict=True)])


def travelling_ripple(expected: np.ndarray, strength: float, rng: np.random.Generator) -> np.ndarray:
    """A ripple over the bins that travels from frame to frame and from zone to zone."""
    f, p, t = np.indices(expected.shape, sparse=True)
    wave = np.sin(2 * np.pi * (t / rng.uniform(6, 20) + f * rng.uniform(0.03, 0.2) + p * rng.uniform(0.1, 0.4)))
    return expected * (1 + np.clip(strength, 0, 0.9) * wave)


def stale_frames(expected: np.ndarray, strength: float, rng: np.random.Generator) -> np.ndarray:
    """Part of every fourth frame's counts are those of the frame before."""
    out = expected.copy()
    out[4::4] += np.clip(strength, 0, 1) * (expected[3:-1:4][: len(out[4::4])] - expected[4::4])
    return out


def deaf_bins(expected: np.ndarray, strength: float, rng: np.random.Generator) -> np.ndarray:
    """One zone is deaf in some bins, in the second half of the session."""
    out = expected.copy()
    zone = int(rng.integers(expected.shape[1]))
    centre = int(np.argmax(expected[:, zone].sum(axis=0))) + int(rng.integers(-2, 3))
    out[len(out) // 2 :, zone, max(centre - 2, 0) : centre + 3] *= max(0.0, 1 - strength)
    return out


STRANGERS: dict[str, Stranger] = {
    f.__name__: f
    for f in (
        warming_pulse, every_other_pulse, leak_to_next_zone, blinking_zone, hum, trembling_clock,
        travelling_ripple, stale_frames, deaf_bins,
    )
}  # fmt: skip

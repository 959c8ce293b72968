"""A window of bins about the highest of each histogram, as firmware keeps that looks for one pulse."""

import numpy as np

# Windows that are told by data end at most so many bins from the highest.
FARTHEST = 24
# Fewer counts than this are expected nowhere that tells anything.
LEAST = 1.0
# What no division may meet.
NOTHING = 1e-12


def inside(counts: np.ndarray, before: float, after: float) -> np.ndarray:
    """(..., T) part of each bin that is from so many bins before the highest of (..., T) to so many after it."""
    away = _away(counts)
    return np.clip(before + 1 + away, 0, 1) * np.clip(after + 1 - away, 0, 1)


def centroid(counts: np.ndarray, about: float) -> np.ndarray:
    """(..., 1) bins from the start of the first to the mean of (..., T) counts so many bins about the highest."""
    near = counts * inside(counts, about, about)
    total = near.sum(axis=-1, keepdims=True)
    middle = (near @ (np.arange(counts.shape[-1]) + 0.5))[..., None]
    return middle / np.maximum(total, NOTHING)


def told_window(excess: np.ndarray, expected: np.ndarray, cut: np.ndarray) -> tuple[float, float, float]:
    """Bins before and after the highest within which counts differ most clearly from those beyond, and by what part.

    excess, expected: (F, P, T). cut: (F, P, T) what of them a window cuts off. Contrast of the excess by what is cut,
    told by weighted least squares, inside with that outside, by the noise of both: of all windows that end at a whole
    bin.
    """
    away = _away(expected).ravel()
    near = np.abs(away) <= FARTHEST
    place = np.where(near, away + FARTHEST, 2 * FARTHEST + 1)
    weight = cut / np.maximum(expected, NOTHING)
    lacking, there = (np.bincount(place, (of * weight).ravel(), minlength=2 * FARTHEST + 2) for of in (-excess, cut))
    lacks, has = (np.concatenate([[0.0], np.cumsum(each[:-1])]) for each in (lacking, there))
    first, last = np.indices((FARTHEST, FARTHEST))
    within = [total[FARTHEST + last + 1] - total[FARTHEST - first] for total in (lacks, has)]
    beyond = [total.sum() - part for total, part in zip((lacking, there), within, strict=True)]
    (left_in, many_in), (left_out, many_out) = (
        (1 - lost / np.maximum(due, LEAST), np.maximum(due, LEAST)) for lost, due in (within, beyond)
    )
    clear = np.maximum(left_in - left_out, 0) ** 2 / (1 / many_in + 1 / many_out)
    best = np.unravel_index(int(np.argmax(clear)), clear.shape)
    part = 1 - left_out[best] / left_in[best] if left_in[best] > 0 else 0.0
    return float(best[0]), float(best[1]), float(np.clip(part, 0, 1))


def _away(counts: np.ndarray) -> np.ndarray:
    """(..., T) bins from the highest, negative before it."""
    return np.arange(counts.shape[-1]) - counts.argmax(axis=-1)[..., None]

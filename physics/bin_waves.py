"""Waves over the bins that a misfit shows: of which periods, where bins move with their widths and where they stay."""

import numpy as np

# Frequencies that are told apart over T bins are 1 / T apart: so many lie between two of them.
FINER = 4


def telling_period(excess: np.ndarray, expected: np.ndarray, moved: bool, low: float, high: float) -> float:
    """Period in bins, from `low` to `high`, of the wave of edges that explains most of an excess.

    excess, expected: (F, P, T) counts. moved: whether bins move as their edges do, or are wider and narrower in place.
    Least squares, weighted by the noise, of a sine and a cosine at each frequency beside a constant factor: what Lomb
    (1976, Astrophys. Space Sci. 39, 447) does for samples of unequal weight, here for all frames and zones at once.
    """
    bins = expected.shape[-1]
    frequency = np.arange(1 / high, 1 / low, 1 / (FINER * bins))
    if not len(frequency):
        return low
    promised, information = _by_edge(excess, expected) if moved else _by_bin(excess, expected)
    at = np.arange(len(promised)) + (0.0 if moved else 0.5)
    angle = 2 * np.pi * frequency[:, None] * at
    # Without movement a constant is the gain, which is fitted; where edges move it is a delay.
    waves = np.stack([np.sin(angle), np.cos(angle), np.ones_like(angle)], axis=1)
    matrix = np.einsum("wie,ef,wjf->wij", waves, information, waves, optimize=True)
    vector = waves @ promised
    scale = matrix[:, 2, 2].max(initial=0)
    if not scale > 0:
        return low
    solved = np.linalg.solve(matrix + 1e-9 * scale * np.eye(3), vector[..., None])[..., 0]
    return float(1 / frequency[np.argmax((solved * vector).sum(axis=1))])


def _by_bin(excess: np.ndarray, expected: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(T,) score and (T, T) information of a factor on each bin."""
    return excess.sum(axis=(0, 1)), np.diag(expected.sum(axis=(0, 1)))


def _by_edge(excess: np.ndarray, expected: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(T - 1,) score and (T - 1, T - 1) information of the displacement of each edge between two bins.

    An edge moves counts of the bin after it into the one before, as many as there are at the edge.
    """
    mean = np.maximum(expected, 1)
    there = (expected[..., 1:] + expected[..., :-1]) / 2
    relative = excess / mean
    promised = (there * (relative[..., :-1] - relative[..., 1:])).sum(axis=(0, 1))
    own = (there**2 * (1 / mean[..., :-1] + 1 / mean[..., 1:])).sum(axis=(0, 1))
    shared = -(there[..., :-1] * there[..., 1:] / mean[..., 1:-1]).sum(axis=(0, 1))
    return promised, np.diag(own) + np.diag(shared, 1) + np.diag(shared, -1)

"""Misfit of many signals at once, against least squares one by one."""

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from fusion.map_scores import Candidates, misfit


def test_misfit_is_that_of_least_squares():
    rng = np.random.default_rng(0)
    signals = rng.uniform(0, 50, (2, 3, 4, 20))
    counts, weights = rng.uniform(0, 90, (2, 3, 20)), rng.uniform(0, 1, (2, 3, 20))
    found = Candidates.of(signals).misfit(counts, weights)
    for f, p, c in np.ndindex(found.shape):
        root = np.sqrt(weights[f, p])
        line = np.stack([signals[f, p, c], np.ones(20)], axis=1) * root[:, None]
        best = lsq_linear(line, counts[f, p] * root, bounds=([0, -np.inf], np.inf))
        assert found[f, p, c] == pytest.approx(2 * best.cost, rel=1e-4)
        assert misfit(counts[f, p], weights[f, p], signals[f, p, c]) == pytest.approx(2 * best.cost, rel=1e-9)


def test_a_signal_that_fits_scores_best():
    signal = np.exp(-0.5 * ((np.arange(40) - np.array([15, 18, 21])[:, None]) / 2) ** 2)
    counts = 300 * signal[1] + 20
    scores = Candidates.of(signal[None, None]).score(counts[None, None], 1 / counts[None, None])
    assert scores[0, 0].argmax() == 1

"""The period that tells most, against least squares done wave by wave over all cells."""

import numpy as np
import pytest
from scipy.stats import norm

from physics.bin_waves import telling_period

RNG = np.random.default_rng(7)


def pulses(frames=6, bins=60):
    at = RNG.uniform(15, 45, (frames, 2, 1))
    return 5 + 900 * np.diff(norm(at, 4.0).cdf(np.arange(bins + 1)), axis=-1)


def gain_of(excess, expected, moved, period):
    """Weighted squares that a sine, a cosine and a constant at this period explain, each cell a row."""
    if moved:
        there = (expected[..., 1:] + expected[..., :-1]) / 2
        waves = (np.sin, np.cos, lambda angle: np.ones_like(angle))
        at = 2 * np.pi * np.arange(there.shape[-1]) / period
        flows = [np.pad(there * wave(at), ((0, 0), (0, 0), (1, 1))) for wave in waves]
        columns = [np.diff(flow, axis=-1) for flow in flows]
    else:
        at = 2 * np.pi * (np.arange(expected.shape[-1]) + 0.5) / period
        columns = [expected * wave for wave in (np.sin(at), np.cos(at), np.ones_like(at))]
    root = 1 / np.sqrt(np.maximum(expected, 1)).ravel()
    a, b = np.stack([column.ravel() * root for column in columns], axis=1), excess.ravel() * root
    return (b**2).sum() - ((b - a @ np.linalg.lstsq(a, b, rcond=None)[0]) ** 2).sum()


@pytest.mark.parametrize("moved", [True, False])
def test_no_other_period_explains_more(moved):
    expected = pulses()
    excess = RNG.poisson(expected) - expected
    found = telling_period(excess, expected, moved, 3.0, 60.0)
    best = gain_of(excess, expected, moved, found)
    for frequency in np.arange(1 / 60, 1 / 3, 1 / 240):
        assert gain_of(excess, expected, moved, 1 / frequency) <= best * (1 + 1e-6)


@pytest.mark.parametrize("moved", [True, False])
def test_where_nothing_is_there_it_is_within_bounds(moved):
    for expected in (np.zeros((2, 3, 40)), np.full((2, 3, 40), 7.0), np.ones((1, 1, 3))):
        assert 2.5 <= telling_period(np.zeros_like(expected), expected, moved, 2.5, 200.0) <= 200.0001

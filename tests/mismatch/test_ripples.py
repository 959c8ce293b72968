"""Ripples: noise has none, whatever it expects; one whose phase is another in each frame is found, with its period."""

import numpy as np
import pytest
from scipy.stats import kstest

from mismatch.ripples import ripples, strongest


def pulses(frames, bins, rng, height):
    """(F, 1, T) a pulse somewhere in each histogram, over a pedestal."""
    at = rng.uniform(10, bins - 10, frames)[:, None]
    return (1 + height * np.exp(-(((np.arange(bins) - at) / 3) ** 2) / 2))[:, None]


@pytest.mark.parametrize("height", [0.3, 5.0, 400.0])
def test_the_power_of_noise_has_the_mean_and_scatter_that_are_said(height):
    """Against draws: the chance of one wave is uniform where it is not the best of many."""
    rng = np.random.default_rng(3)
    mean = pulses(40, 32, rng, height)
    drawn = [rng.poisson(mean) - mean for _ in range(400)]
    best = [strongest(one[:, 0], mean[:, 0])[0] for one in drawn]
    # The best of as many as there are, which go by halves with their neighbours: small no oftener than it should be.
    assert np.mean(np.array(best) < 0.1) < 0.13
    assert np.mean(np.array(best) < 0.01) < 0.03
    assert kstest(np.minimum(best, 1), "uniform", alternative="greater").pvalue > 1e-3


@pytest.mark.parametrize("period", [5.0, 7.3, 16.0])
def test_a_ripple_is_found_with_its_period(period):
    rng = np.random.default_rng(5)
    mean = np.repeat(pulses(60, 64, rng, 0.5) * 100, 3, axis=1)
    phase = rng.uniform(0, 2 * np.pi, (60, 1, 1))
    rippled = mean * (1 + 0.05 * np.cos(2 * np.pi * np.arange(64) / period + phase))
    by_frame, by_histogram = ripples(rng.poisson(rippled) - mean, mean)
    assert by_frame.p_value < 1e-6
    assert float(by_frame.sentence.split()[3]) == pytest.approx(period, rel=0.08)
    # Each zone by itself tells less, unless each has a phase of its own.
    assert by_histogram.p_value > by_frame.p_value
    each = mean * (1 + 0.08 * np.cos(2 * np.pi * np.arange(64) / period + rng.uniform(0, 2 * np.pi, (60, 3, 1))))
    by_frame, by_histogram = ripples(rng.poisson(each) - mean, mean)
    assert by_histogram.p_value < min(by_frame.p_value, 1e-6)


def test_few_counts_tell_nothing():
    assert strongest(np.zeros((3, 8)), np.full((3, 8), 0.1))[0] == 1.0

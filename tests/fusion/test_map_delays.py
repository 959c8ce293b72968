"""Delays of zones, against shapes that are known in closed form."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import erf

from fusion.map_delays import SIGMA_S, best_bins, profiled, sought_bins, steps_bins
from fusion.map_scores import delayed

BIN_S = 1e-10


def pulse(centre, width=1.5):
    """Counts of a Gaussian pulse in 40 bins."""
    edges = (np.arange(41) - 0.5 - centre) / (width * np.sqrt(2))
    return 500 * np.diff(erf(edges))


@settings(max_examples=30)
@given(st.floats(-5, 5))
def test_a_delayed_pulse_is_a_pulse_that_came_later(bins):
    """To a hundredth of its peak."""
    assert delayed(pulse(20), bins) == pytest.approx(pulse(20 + bins), abs=2.5)


def test_whole_bins_are_exact_and_each_histogram_has_its_own_delay():
    both = delayed(np.stack([pulse(20), pulse(20)]), np.array([3, -2]))
    assert np.allclose(both[0, 3:], pulse(20)[:-3])
    assert np.allclose(both[1, :-2], pulse(20)[2:])


@settings(max_examples=30)
@given(st.floats(-1.5, 1.5), st.floats(1, 50))
def test_the_best_delay_weighs_likelihood_and_prior(truth, weight):
    """A parabola times a Gaussian prior: the mean of the two, weighed by their precisions."""
    score = -0.5 * weight * (sought_bins(BIN_S) - truth) ** 2
    prior = (BIN_S / SIGMA_S) ** 2
    expected = weight * truth / (weight + prior)
    assert best_bins(score[None], BIN_S)[0] == pytest.approx(expected, abs=1e-6)


def test_the_profile_is_the_top_of_the_parabola():
    weight, truth, centre = np.array([3.0, 8.0]), np.array([0.4, -0.2]), 0.1
    tried = centre + steps_bins(BIN_S)
    score = -0.5 * weight[:, None] * (tried - truth[:, None]) ** 2
    prior = (BIN_S / SIGMA_S) ** 2
    expected = -0.5 * weight * prior / (weight + prior) * truth**2
    assert profiled(score[None], np.array([centre]), BIN_S)[0] == pytest.approx(expected, abs=1e-6)


def test_where_likelihood_is_lowest_between_the_highest_end_counts():
    """Prior and all: 5 at the end, less a half for a delay of one standard deviation."""
    assert profiled(np.array([[[5.0, -9.0, 1.0]]]), np.zeros(1), BIN_S)[0, 0] == pytest.approx(4.5)

"""Deviance against scipy's Poisson distribution, summed over all counts that can be."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import poisson

from mismatch.poisson import LEAST, MANY, deviance, expected_deviance, signed


def by_definition(counts, mean):
    """Twice the log-likelihood ratio of the saturated model and this one; 0 counts are certain where 0 are expected."""
    return 2 * (poisson.logpmf(counts, np.where(counts > 0, counts, 0)) - poisson.logpmf(counts, mean))


@given(st.integers(0, 100_000), st.floats(LEAST, 1e5))
def test_deviance_is_twice_the_log_likelihood_ratio(counts, mean):
    assert deviance(np.array(counts), np.array(mean)) == pytest.approx(
        by_definition(np.array(counts), mean), rel=1e-6, abs=1e-6
    )


@pytest.mark.parametrize("mean", [LEAST, 0.02, 0.3, 1.0, 4.7, 25.0, MANY - 0.01, MANY, 300.0])
def test_mean_and_variance_are_those_of_sums_over_all_counts(mean):
    counts = np.arange(poisson.ppf(1 - 1e-15, mean) + 30)
    chance, each = poisson.pmf(counts, mean), by_definition(counts, mean)
    first = (chance * each).sum()
    found = expected_deviance(np.array(mean))
    assert found[0] == pytest.approx(first, rel=2e-3)
    assert found[1] == pytest.approx((chance * each**2).sum() - first**2, rel=2e-3)


@pytest.mark.parametrize("mean", [0.0, 1e-9, 1e-5, 3e-4])
def test_where_next_to_nothing_is_expected_deviance_is_that_about_the_least(mean):
    counts = np.arange(6)
    chance, each = poisson.pmf(counts, mean), by_definition(counts, LEAST)
    first = (chance * each).sum()
    found = expected_deviance(np.array(mean))
    assert found[0] == pytest.approx(first, rel=2e-3)
    assert found[1] == pytest.approx((chance * each**2).sum() - first**2, rel=2e-2, abs=1e-9)


@given(st.integers(0, 1000), st.floats(LEAST, 1e3))
def test_signed_residuals_square_to_the_deviance_and_point_to_the_counts(counts, mean):
    found = signed(np.array(counts), np.array(mean))
    # Beside equal counts and means the deviance is a difference of large numbers.
    assert found**2 == pytest.approx(deviance(np.array(counts), np.array(mean)), abs=1e-9)
    assert found * (counts - mean) >= 0


def test_a_photon_where_none_is_expected_costs_a_finite_sum():
    assert np.isfinite(deviance(np.array([0, 1, 5]), np.zeros(3))).all()

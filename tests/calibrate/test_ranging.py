"""Distances from histograms: against a search over finely spaced distances, and against the bound on their errors."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize
from scipy.special import xlogy
from scipy.stats import norm

from calibrate.ranging import Templates, ranges
from recordings.refusal import Refusal

BINS, WIDTH_M, SIGMA_M = 40, 0.0136, 0.018
DISTANCE = np.arange(0.05, 0.40, 0.0015)
ZERO_M = np.array([0.02, 0.05])


def shares(distance_m, zone):
    """(..., T) share of a Gaussian pulse in each bin, from its cumulative."""
    edges = WIDTH_M * np.arange(BINS + 1) - ZERO_M[zone]
    return np.diff(norm.cdf(edges, np.asarray(distance_m)[..., None], SIGMA_M), axis=-1)


@pytest.fixture(scope="module")
def templates():
    return Templates(DISTANCE, np.stack([shares(DISTANCE, zone) for zone in range(2)], axis=1))


def drawn(rng, distance_m, gain, pedestal=20.0):
    """(F, 2, T) Poisson counts of a surface at distances (F,)."""
    expected = gain * np.stack([shares(distance_m, zone) for zone in range(2)], axis=1) + pedestal
    return rng.poisson(expected)


def test_it_is_the_maximum_that_a_general_optimiser_finds(templates):
    rng = np.random.default_rng(1)
    counts = drawn(rng, np.array([0.1234, 0.3]), 2000.0)
    found = ranges(counts, templates)

    for frame in range(2):
        for zone in range(2):

            def loss(x, c=counts[frame, zone], zone=zone):
                rate = np.exp(x[1]) * shares(x[0], zone) + np.exp(x[2])
                return (rate - xlogy(c, rate)).sum()

            start = [found.range_m[frame, zone] + 0.003, np.log(1800.0), np.log(25.0)]
            best = minimize(loss, start, method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-9, "maxiter": 4000})
            assert found.range_m[frame, zone] == pytest.approx(best.x[0], abs=2e-6)
            assert np.log(found.gain[frame, zone]) == pytest.approx(best.x[1], abs=1e-3)


def test_errors_are_those_stated_and_no_smaller_than_photons_allow(templates):
    rng = np.random.default_rng(2)
    truth = rng.uniform(0.08, 0.36, 600)
    found = ranges(drawn(rng, truth, 3000.0), templates)
    pulls = (found.range_m - truth[:, None]) / found.sigma_m
    assert np.abs(pulls.mean()) < 4 / np.sqrt(pulls.size)
    assert pulls.std() == pytest.approx(1, abs=0.1)
    # A Gaussian pulse without pedestal: σ/√N, and bins of 0.75 σ cost a few percent (Sheppard: 1 + w²/12σ²).
    bare = ranges(drawn(rng, truth, 3000.0, 0.0), templates)
    bound = SIGMA_M / np.sqrt(3000) * np.sqrt(1 + WIDTH_M**2 / 12 / SIGMA_M**2)
    assert np.median(bare.sigma_m) == pytest.approx(bound, rel=0.03)
    assert bare.deviance.mean() < 1.1


def test_pile_up_is_no_error_of_distance_where_shots_are_known(templates):
    rng = np.random.default_rng(3)
    shots, truth = 20_000, np.linspace(0.1, 0.3, 30)
    rate = 16_000 * np.stack([shares(truth, zone) for zone in range(2)], axis=1)
    # Each shot by itself: the first bin in which any photon arrives.
    counts = np.zeros(rate.shape, int)
    for index in np.ndindex(rate.shape[:2]):
        hit = 1 - np.exp(-rate[index] / shots)
        first = hit * np.concatenate([[1.0], np.cumprod(1 - hit)[:-1]])
        counts[index] = rng.multinomial(shots, np.append(first, 1 - first.sum()))[:-1]
    with_shots, without = ranges(counts, templates, shots), ranges(counts, templates)
    assert np.abs((with_shots.range_m - truth[:, None]).mean()) < 1e-4
    assert (without.range_m - truth[:, None]).mean() < -2e-3
    assert with_shots.gain.mean() == pytest.approx(16_000, rel=0.01)


@settings(max_examples=25, deadline=None)
@given(distance=st.floats(0.06, 0.38), log_gain=st.floats(4, 14), pedestal=st.floats(0, 100))
def test_expected_counts_give_the_distance_back(distance, log_gain, pedestal):
    table = Templates(DISTANCE, np.stack([shares(DISTANCE, zone) for zone in range(2)], axis=1))
    counts = np.exp(log_gain) * np.stack([shares(np.array([distance]), z) for z in range(2)], axis=1) + pedestal
    # Faint light under a bright pedestal may start anywhere.
    if np.exp(log_gain) > 20 * pedestal:
        assert ranges(counts, table).range_m == pytest.approx(distance, abs=2e-5)


def test_what_has_no_distance_gets_none(templates):
    counts = np.zeros((1, 2, BINS))
    counts[0, 1] = 1000 * shares(0.03, 1)
    found = ranges(counts, templates)
    assert np.isnan(found.range_m).all()
    assert np.isinf(found.sigma_m).all()


def test_what_cannot_be_used_is_refused(templates):
    with pytest.raises(Refusal, match=r"expected \(F, 2, 40\)"):
        ranges(np.zeros((3, 4, 40)), templates)
    with pytest.raises(Refusal, match="photon counts"):
        ranges(np.full((1, 2, BINS), -1.0), templates)
    with pytest.raises(Refusal, match="evenly spaced"):
        Templates(DISTANCE**2, templates.expected)
    with pytest.raises(Refusal, match=r"\(K,\) and \(K, P, T\)"):
        Templates(DISTANCE[:-1], templates.expected)
    with pytest.raises(Refusal, match="laser shots"):
        ranges(np.full((1, 2, BINS), 10.0), templates, shots=100)

"""Errors of depth images that can be told by hand."""

import numpy as np
import pytest

from fusion.quality.metrics import at_edges, coverage, errors


def test_errors_by_hand():
    truth = np.array([[1.0, 2.0, np.nan, 4.0]])
    depth = np.array([[1.04, 2.3, 9.0, np.nan]])
    where = np.array([[True, True, True, False]])
    found = errors(depth, truth, where)
    assert found["rms"] == pytest.approx(np.sqrt((0.04**2 + 0.3**2) / 2))
    assert found["median"] == pytest.approx(0.17)
    assert found["close"] == 0.5


def test_silence_is_an_error():
    assert errors(np.array([[np.nan]]), np.array([[2.0]]), np.array([[True]]))["rms"] == 2.0


def test_within_five_percent_both_ways():
    truth = np.full((1, 4), 2.0)
    depth = 2.0 * np.array([[1.049, 1.051, 1 / 1.049, 1 / 1.051]])
    assert errors(depth, truth, np.ones((1, 4), bool))["close"] == 0.5


def test_edges_are_near_a_jump():
    truth = np.ones((60, 60))
    truth[:, 30:] = 1.5
    found = at_edges(truth)
    assert found[:, 26:34].all()
    assert not found[:, :15].any()
    assert not found[:, 45:].any()
    assert not at_edges(np.full((30, 30), np.nan)).any()


def test_normal_errors_are_covered_nine_times_in_ten():
    rng = np.random.default_rng(0)
    sigma = rng.uniform(0.1, 1, (200, 200))
    truth = 3 + sigma * rng.normal(size=sigma.shape)
    assert coverage(np.full(sigma.shape, 3.0), sigma, truth, np.ones(sigma.shape, bool)) == pytest.approx(
        0.9, abs=0.006
    )

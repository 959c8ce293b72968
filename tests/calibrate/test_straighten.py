"""Centroids against sums by hand, and readings that become metres with as much freedom as was given."""

import numpy as np
import pytest

from calibrate.ranging.centroid import centroid_bins
from calibrate.ranging.straighten import CURVES, LINES, SHARED, straighten
from recordings.refusal import Refusal


def test_centroid_of_bins_about_the_peak():
    counts = np.array([5, 5, 5, 15, 45, 25, 5, 5, 5, 5])
    assert centroid_bins(counts) == pytest.approx((3 * 10 + 4 * 40 + 5 * 20) / 70)
    assert centroid_bins(counts, 0, 0) == 4
    # At the window's edge there is less to sum.
    assert centroid_bins(np.array([40, 10, 0, 0, 0, 0, 0])) == pytest.approx(10 / 50)
    assert np.isnan(centroid_bins(np.full((2, 8), 3))).all()
    with pytest.raises(Refusal, match="fewer than 8"):
        centroid_bins(np.ones(8), 4, 4)


def test_losses_to_earlier_photons_are_made_good():
    rate, shots = np.array([0, 0, 300.0, 600.0, 200.0, 0, 0, 0]), 1000
    survive = np.exp(-np.concatenate([[0], np.cumsum(rate)]) / shots)
    counts = shots * (survive[:-1] - survive[1:])
    truth = (2 * 300 + 3 * 600 + 4 * 200) / 1100
    assert centroid_bins(counts, shots=shots) == pytest.approx(truth)
    assert centroid_bins(counts) < truth - 0.05


@pytest.mark.parametrize(
    ("freedom", "numbers", "bend", "scale", "error"),
    [
        (LINES, 6, lambda x: 0 * x, (1.0, 1.1, 0.9), 1e-12),
        (SHARED, 8, lambda x: 0.1 * x**2 + 0.05 * x**3, (1.0, 1.0, 1.0), 1e-12),
        (CURVES, 21, np.sin, (1.0, 1.1, 0.9), 1e-3),
    ],
)
def test_each_freedom_takes_up_what_bends_as_it_can(freedom, numbers, bend, scale, error):
    x, zero = np.linspace(-0.9, 0.9, 60), np.array([0.3, 0.0, -0.2])
    # One true distance a frame, which zones read differently.
    readings = (x[:, None] - (0 if freedom == SHARED else zero)) / np.array(scale)
    metres, even = x + bend(x), np.arange(60) % 2 == 0
    found = straighten(readings, metres, even, freedom)
    assert found.parameters == numbers
    assert np.abs(found.metres - metres[:, None]).max() < error
    if freedom != LINES:
        assert np.abs(straighten(readings, metres, even, LINES).metres - metres[:, None]).max() > 0.02


def test_distances_of_frames_that_test_are_not_looked_at():
    rng = np.random.default_rng(0)
    metres, even = np.linspace(0, 1, 40), np.arange(40) % 2 == 0
    readings = metres[:, None] + rng.normal(0, 0.01, (40, 2))
    for freedom in (LINES, SHARED, CURVES):
        told = straighten(readings, metres, even, freedom).metres
        assert np.array_equal(told, straighten(readings, np.where(even, metres, 7.0), even, freedom).metres)


def test_too_few_frames_and_wrong_shapes_are_refused():
    metres = np.linspace(0, 1, 4)
    with pytest.raises(Refusal, match="expected more frames"):
        straighten(np.ones((4, 3)) * metres[:, None], metres, np.array([1, 0, 0, 0]), LINES)
    with pytest.raises(Refusal, match="have shapes"):
        straighten(np.ones((4, 3)), metres[:3], np.ones(4), LINES)
    with pytest.raises(Refusal, match="NaN"):
        straighten(np.full((4, 3), np.nan), metres, np.ones(4), LINES)
    with pytest.raises(Refusal, match="freedom"):
        straighten(np.ones((4, 3)), metres, np.ones(4), "any")

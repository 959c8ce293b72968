"""Interference against where its pulse's mean must lie, and its sum."""

import numpy as np
import pytest

from physics.effects.interference import effect
from physics.nominal import ForwardModel


@pytest.fixture
def model(small):
    return ForwardModel(small.light, small.footprints, small.clock, 4.0)


def more(model, **values):
    return model.expected(1e3, [effect.at(**values)]) - model.expected(1e3)


def test_its_counts_are_those_given_in_each_zone(model):
    counts = np.array([0, 10, 200, 1e4])
    found = more(model, counts=counts, arrival=3e-9).sum(axis=-1)
    np.testing.assert_allclose(found, np.broadcast_to(counts, found.shape), rtol=1e-5, atol=1e-8)


def test_its_mean_arrival_wanders_by_drift_times_time(model, small):
    found = more(model, arrival=2e-9, drift=1e-8)[:, 0]
    centres = (np.arange(found.shape[-1]) + 0.5) * small.clock.bin_width_s
    mean = found @ centres / found.sum(axis=-1)
    np.testing.assert_allclose(np.diff(mean), 1e-8 * 0.1, atol=2e-12)


def test_it_enters_the_window_without_a_jump(model, small):
    arrivals = np.linspace(-8e-9, 2e-9, 201)
    totals = np.array([more(model, arrival=a, drift=0)[0, 0].sum() for a in arrivals])
    assert totals[0] < 1e-2
    assert totals[-1] == pytest.approx(100, rel=1e-3)
    # In 50 ps no more comes in than the fullest 50 ps of the pulse hold.
    most = np.diff(small.clock.pulse.cumulative(np.arange(-1e-9, 4e-9, 25e-12)))
    assert np.diff(totals).max() < 100 * 2.2 * most.max()


def test_outside_the_window_it_is_not_seen(model):
    assert np.abs(more(model, arrival=30e-9, drift=0)).max() < 1e-6

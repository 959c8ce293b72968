"""A delay against the sensor with other time zeros, and against histograms moved by whole bins."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from physics.arrivals import Arrivals
from physics.clock import Clock
from physics.effects.time_zero_offset import effect
from physics.nominal import ForwardModel
from physics.pulse import ImpulseResponse, two_piece_pulse


def counts(small, delay):
    return ForwardModel(small.light, small.footprints, small.clock).expected(1e3, [effect.at(delay=delay)])


def test_whole_bins_move_the_histogram(small):
    width = small.clock.bin_width_s
    nominal, found = counts(small, 0), counts(small, [0, width, 3 * width, -2 * width])
    np.testing.assert_array_equal(found[:, 0], nominal[:, 0])
    np.testing.assert_allclose(found[:, 1, 1:], nominal[:, 1, :-1], atol=1e-8)
    np.testing.assert_allclose(found[:, 2, 3:], nominal[:, 2, :-3], atol=1e-8)
    np.testing.assert_allclose(found[:, 3, :-4], nominal[:, 3, 2:-2], atol=1e-8)


@pytest.mark.parametrize("delay", [-5e-11, 2.3e-11, 5e-11])
def test_it_is_another_time_zero(small, delay):
    clock = replace(small.clock, time_zero_s=small.clock.time_zero_s + delay)
    other = ForwardModel(small.light, small.footprints, clock).expected(1e3)
    np.testing.assert_allclose(counts(small, delay), other, atol=3e-3 * other.max())
    assert np.abs(counts(small, 0) - other).max() > 2e-2 * other.max()


@pytest.mark.parametrize("delay", [3.3e-11, 6.5e-11])
@pytest.mark.parametrize("per_bin", [1, 4])
def test_a_response_in_coarse_steps_does_not_become_wider(small, delay, per_bin):
    """Half of a step away, where light would be shared by two knots a whole step apart."""
    step = small.clock.bin_width_s / per_bin
    pulse = ImpulseResponse(step * (np.arange(6) - 2), np.array([0.05, 0.3, 0.35, 0.2, 0.08, 0.02]))
    clock = replace(small.clock, pulse=pulse)
    there = replace(clock, time_zero_s=clock.time_zero_s + delay)
    found, wanted = (
        ForwardModel(small.light, small.footprints, one).expected(1e3, settings)
        for one, settings in ((clock, [effect.at(delay=delay)]), (there, []))
    )
    np.testing.assert_allclose(found, wanted, atol=3e-3 * wanted.max())


@given(delay=st.floats(-1e-10, 1e-10))
def test_the_mean_arrival_moves_by_the_delay_and_light_is_kept(delay):
    pulse = two_piece_pulse(1e-10, 2e-10, 2e-11)
    clock = Clock(2e-10, 30, np.zeros(2), pulse)
    light = np.zeros((1, 2, clock.lattice.size))
    light[0, 0, 50], light[0, 1, 90:120] = 3.0, np.arange(30)
    start = SimpleNamespace(arrivals=Arrivals(light, clock.lattice, 30))
    found = effect.arrivals(effect.at(delay=delay).values, start).light
    knots = np.arange(clock.lattice.size) * clock.lattice.step_s
    total = light.sum(axis=-1)
    np.testing.assert_allclose(found.sum(axis=-1), total, rtol=1e-12)
    np.testing.assert_allclose((found @ knots - light @ knots) / total, delay, atol=1e-20)

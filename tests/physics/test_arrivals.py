"""The kernel against the sum written out pixel by pixel."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from physics.arrivals import arrivals
from physics.clock import TOLERANCE, Clock
from physics.pulse import ImpulseResponse
from recordings.refusal import Refusal

from .conftest import slow_model


def test_every_bin_is_that_of_the_sum_over_pixels(small):
    clock = small.clock
    got = arrivals(small.light, small.footprints, clock).binned()
    expected = slow_model(small.light, small.footprints.weights, clock.bin_width_s, 40, clock.time_zero_s, clock.pulse)
    # Weights and strengths are held in float32.
    np.testing.assert_allclose(got, expected, rtol=1e-6, atol=1e-9 * expected.max())


def test_a_response_whose_steps_do_not_divide_the_bin_keeps_its_bound(small):
    steps = np.arange(-30, 60)
    probability = np.exp(-0.5 * (steps / 9) ** 2)
    pulse = ImpulseResponse(steps * 17.3e-12, probability / probability.sum())
    clock = replace(small.clock, pulse=pulse)
    assert 0 < clock.lattice.error <= TOLERANCE
    got = arrivals(small.light, small.footprints, clock).binned()
    expected = slow_model(small.light, small.footprints.weights, clock.bin_width_s, 40, clock.time_zero_s, pulse)
    light = (small.footprints.weights[None] * small.light.returns[0].strength[:, None]).sum(axis=(2, 3))
    assert (np.abs(got - expected) <= 1.001 * TOLERANCE * light[:, :, None]).all()
    assert np.abs(got - expected).max() < 1e-3 * expected.max()


@given(
    arrival_bins=st.floats(-12, 30),
    per_bin=st.integers(1, 9),
    steps=st.integers(2, 40),
    first=st.integers(-30, 10),
    seed=st.integers(0, 99),
)
def test_one_photon_at_any_time_is_binned_as_its_response_says(arrival_bins, per_bin, steps, first, seed):
    width, bins = 1e-9, 20
    probability = np.random.default_rng(seed).random(steps)
    times = (np.arange(steps) + first) * width / per_bin
    pulse = ImpulseResponse(times, probability / probability.sum())
    clock = Clock(width, bins, np.full(1, -12 * width), pulse)
    empty = arrivals_of_nothing(clock)
    got = empty.added(1.0, arrival_bins * width).binned()[0, 0]
    np.testing.assert_allclose(got, pulse.in_bins(arrival_bins * width, bins, width), atol=1e-9)


def arrivals_of_nothing(clock):
    from physics.arrivals import Arrivals

    return Arrivals(np.zeros((1, 1, clock.lattice.size)), clock.lattice, clock.bins)


@given(delay_bins=st.floats(-8, 8))
def test_a_delay_moves_the_mean_and_keeps_the_light(delay_bins):
    clock = Clock(1e-9, 40, np.zeros(1), ImpulseResponse(np.array([-0.25e-9, 0, 0.25e-9]), np.array([0.25, 0.5, 0.25])))
    here = arrivals_of_nothing(clock).added(3.0, 20.3e-9)
    there = here.delayed(delay_bins * 1e-9).binned()[0, 0]
    assert there.sum() == pytest.approx(3)
    moved = (there - here.binned()[0, 0]) @ np.arange(40) / 3
    assert moved == pytest.approx(delay_bins, abs=0.51)  # Bins round: half a bin either way at most.
    knots = np.arange(clock.lattice.size)
    mean = (here.delayed(delay_bins * 1e-9).light - here.light)[0, 0] @ knots / 3 / clock.lattice.per_bin
    assert mean == pytest.approx(delay_bins, abs=1e-9)


def test_light_outside_the_window_is_left_out(small):
    late = replace(small.clock, time_zero_s=np.full(4, 1e-6))
    assert arrivals(small.light, small.footprints, late).binned().sum() == 0
    early = replace(small.clock, time_zero_s=np.full(4, -1e-6))
    assert arrivals(small.light, small.footprints, early).binned().sum() == 0


def test_zones_and_grids_that_do_not_match_are_refused(small):
    with pytest.raises(Refusal, match="time_zero_s has shape"):
        arrivals(small.light, small.footprints, replace(small.clock, time_zero_s=np.zeros(3)))
    wrong = replace(small.footprints, x_px=np.zeros((2, 2)), y_px=np.zeros((2, 2)))
    with pytest.raises(Refusal, match="footprints on a grid"):
        arrivals(small.light, wrong, small.clock)


def test_footprints_may_move_from_frame_to_frame(small):
    shift = np.array([0.0, 60.0, -40.0])[:, None, None]
    moved = small.footprints.moved(shift, 0 * shift)
    got = arrivals(small.light, moved, small.clock).binned()
    for f, dx in enumerate(shift.ravel()):
        alone = arrivals(small.light, small.footprints.moved(dx, 0), small.clock).binned()
        np.testing.assert_allclose(got[f], alone[f], rtol=1e-12)


def test_each_row_is_delayed_by_its_own_time_and_lost_beyond_the_lattice(small):
    """Against linear interpolation: light between two knots is shared, and what leaves does not come back."""
    first = arrivals(small.light, small.footprints, small.clock)
    size, step = first.lattice.size, first.lattice.step_s
    steps = np.random.default_rng(3).uniform(-1.2 * size, 1.2 * size, first.light.shape[:2])
    steps[0, 0], steps[-1, -1] = 3.0, -2.5
    moved = first.delayed(steps * step).light
    for f, p in np.ndindex(steps.shape):
        knots = np.arange(size)
        expected = np.interp(knots - steps[f, p], np.arange(-1, size + 1), np.pad(first.light[f, p], 1), 0, 0)
        np.testing.assert_allclose(moved[f, p], expected, atol=1e-12 * first.light.max())
    np.testing.assert_array_equal(first.delayed(0.0).light, first.light)


@given(factor=st.floats(0.9, 1.1), about_bins=st.floats(0, 10), at_bins=st.floats(12, 30))
def test_stretching_moves_light_in_proportion_and_keeps_it(factor, about_bins, at_bins):
    clock = Clock(1e-9, 40, np.zeros(1), ImpulseResponse(np.array([-0.25e-9, 0, 0.25e-9]), np.array([0.25, 0.5, 0.25])))
    stretched = arrivals_of_nothing(clock).added(3.0, at_bins * 1e-9).stretched(factor, about_bins * 1e-9)
    lattice = clock.lattice
    knots_s = lattice.first_s + lattice.step_s * np.arange(lattice.size)
    mean = stretched.light[0, 0] @ knots_s / 3
    assert stretched.light.sum() == pytest.approx(3)
    assert mean == pytest.approx((about_bins + factor * (at_bins - about_bins)) * 1e-9, abs=1e-15)


def test_light_until_a_time_is_that_of_the_sum_over_pixels(small):
    """Times before, between, on and after the bins' edges; each pixel's pulse has its cumulative."""
    clock, direct = small.clock, small.light.returns[0]
    times = np.array([-3.0, 0.0, 7.31, 12.0, 18.62, 25.5, 40.0, 47.2])
    found = arrivals(small.light, small.footprints, clock).until(times)
    arrival = clock.time_zero_s[:, None] + (2 * direct.range_m / 299_792_458).reshape(3, 1, -1)
    until = clock.pulse.cumulative(times[:, None, None, None] * clock.bin_width_s - arrival)
    lit = direct.strength.reshape(3, 1, -1) * small.footprints.weights.reshape(4, -1)
    # Light on knots is as wide as they are apart.
    np.testing.assert_allclose(found, np.einsum("fpu,nfpu->fpn", lit, until), atol=1e-3 * found.max())
    within = times[(times >= 0) & (times <= 40) & (times % 1 == 0)].astype(int)
    total = np.concatenate(
        [[[[0.0]] * 4] * 3, np.cumsum(arrivals(small.light, small.footprints, clock).binned(), 2)], 2
    )
    early = found[..., [1]]
    np.testing.assert_allclose(found[..., np.isin(times, within)], total[..., within] + early, rtol=1e-9, atol=1e-9)

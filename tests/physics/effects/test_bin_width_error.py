"""A wrong clock against sums over pixels with bins of its width, and a target whose place is known in closed form."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mismatch.form import all_forms
from physics.clock import Clock
from physics.effects.bin_width_error import LARGEST, TOLERANCE, effect
from physics.footprint import footprints
from physics.light import direct_light
from physics.nominal import ForwardModel
from physics.pulse import ImpulseResponse, two_piece_pulse
from tests.physics.conftest import C, slow_model


@pytest.mark.parametrize("error", [-0.1, -0.03, 1e-3, 0.01, 0.1])
@pytest.mark.parametrize("per_bin", [16, 7.3])
def test_it_is_the_sum_over_pixels_with_bins_of_that_width(small, error, per_bin):
    pulse = two_piece_pulse(0.12e-9, 0.3e-9, 0.26e-9 / per_bin)
    clock = replace(small.clock, pulse=pulse)
    found = ForwardModel(small.light, small.footprints, clock).expected(1e3, [effect.at(error=error)])
    width, zero = clock.bin_width_s * (1 + error), clock.time_zero_s * (1 + error)
    closed = 1e3 * slow_model(small.light, small.footprints.weights, width, clock.bins, zero, pulse)
    np.testing.assert_allclose(found, closed, atol=TOLERANCE * closed.max())


@pytest.mark.parametrize("error", [-0.07, 0.02])
def test_a_target_at_no_range_stays_and_others_come_nearer_in_proportion(small, maps, error):
    zero, width = 8e-9, 0.26e-9

    def place(depth, **values):
        light = direct_light(np.full((1, 1, 1), depth), np.diag([1e3, 1e3, 1]), None, np.ones((1, 1, 1)))
        clock = Clock(width, 120, np.full(4, zero), two_piece_pulse(0.3e-9, 0.3e-9, width / 16))
        counts = ForwardModel(light, footprints(maps, (1, 1)), clock).expected(1.0, [effect.at(**values)])[0, 0]
        centres = np.arange(120) + 0.5
        mean = counts @ centres / counts.sum()
        return mean, np.sqrt(counts @ (centres - mean) ** 2 / counts.sum() - 1 / 12)

    late = place(2.0, error=error, zero_in_seconds=1)[0]
    assert late == pytest.approx((zero + 4 / C) / width / (1 + error), abs=5e-3)
    # Counts are 1/r² and many: 0.1 mm is range 0 to within 1e-3 of a bin.
    near, wide = place(1e-4, error=error)
    assert near == pytest.approx(zero / width, abs=5e-3)
    assert place(2.0, error=error)[0] == pytest.approx((zero + 4 / C / (1 + error)) / width, abs=5e-3)
    assert wide == pytest.approx(0.3e-9 / width / (1 + error), rel=2e-3)
    there, kept = place(2.0, error=error, pulse_in_bins=1)
    assert there == pytest.approx((zero + 4 / C / (1 + error)) / width, abs=5e-3)
    assert kept == pytest.approx(0.3e-9 / width, rel=2e-3)


def test_background_and_light_are_kept(small):
    clock = replace(small.clock, bins=120)
    model, dark = (ForwardModel(small.light, small.footprints, clock, level) for level in (7.0, None))
    found = dark.expected(1e3, [effect.at(error=0.05)])
    np.testing.assert_allclose(model.expected(1e3, [effect.at(error=0.05)]) - 7, found, atol=1e-9)
    np.testing.assert_allclose(found.sum(axis=-1), dark.expected(1e3).sum(axis=-1), rtol=1e-6)


@given(error=st.floats(-LARGEST, LARGEST), less=st.floats(1e-7, 1e-5))
def test_counts_do_not_jump_and_knots_are_as_many_whatever_the_error(error, less):
    pulse = two_piece_pulse(0.4e-9, 0.9e-9, 1e-9 / 8)
    clock = Clock(1e-9, 20, np.array([3e-9]), ImpulseResponse(pulse.time_s, pulse.probability))

    def shares(error):
        made = effect.clock(effect.at(error=error).values, SimpleNamespace(clock=clock))
        assert made is clock or made.lattice.per_bin == 128
        return made.pulse.in_bins(made.time_zero_s + 9e-9, 20, made.bin_width_s)

    # Edges move by no more than 20 bins' part of the change, and the pulse is less than 1 high in a bin.
    assert np.abs(shares(error) - shares(max(error - less, -LARGEST))).max() < 25 * less


@pytest.mark.parametrize("zero_in_seconds", [0.0, 1.0])
def test_a_clock_that_warms_up_has_in_each_frame_bins_of_their_width_by_then(small, zero_in_seconds):
    """Against clocks that are off by as much all the time; the pulse, whose width stays, is shorter than a bin."""
    clock = replace(small.clock, pulse=two_piece_pulse(0.02e-9, 0.02e-9, small.clock.bin_width_s / 64))
    model, tau = ForwardModel(small.light, small.footprints, clock), 0.15
    warming = effect.at(error=-0.01, warmup=0.04, tau=tau, zero_in_seconds=zero_in_seconds)
    found = model.expected(1e3, [warming])
    for i, time in enumerate((0.0, 0.1, 0.2)):
        error = -0.01 + 0.04 * (1 - np.exp(-time / tau))
        steady = model.expected(1e3, [effect.at(error=error, zero_in_seconds=zero_in_seconds)])
        np.testing.assert_allclose(found[i], steady[i], atol=5e-3 * steady.max())
    # And by more than what is allowed here it is not the nominal clock.
    assert np.abs(found - model.expected(1e3)).max() > 0.05 * found.max()


@pytest.mark.parametrize("zero_in_seconds", [0.0, 0.6])
def test_zones_may_have_clocks_of_their_own(small, zero_in_seconds):
    """Each zone as by a clock that is off by as much in all of them; the pulse is shorter than a bin.

    But for what comes after the nominal window, and into it in wider bins: arrivals there are not known.
    """
    clock = replace(small.clock, pulse=two_piece_pulse(0.02e-9, 0.02e-9, small.clock.bin_width_s / 64))
    model, apart = ForwardModel(small.light, small.footprints, clock), np.array([0.03, 0, -0.02, 0.01])
    found = model.expected(1e3, [effect.at(error=-0.01, apart=apart, zero_in_seconds=zero_in_seconds)])
    for zone, more in enumerate(apart):
        alone = model.expected(1e3, [effect.at(error=-0.01 + more, zero_in_seconds=zero_in_seconds)])
        np.testing.assert_allclose(found[:, zone, :-2], alone[:, zone, :-2], atol=5e-3 * alone.max())
    assert np.abs(found - model.expected(1e3, [effect.at(error=-0.01)])).max() > 0.05 * found.max()


@pytest.mark.parametrize("more", [{}, {"warmup": 0.02, "tau": 0.1}, {"apart": np.array([0.03, 0, -0.02, 0.01])}])
def test_a_target_may_stay_and_others_are_off_from_there_on(maps, more):
    zero, width, still = 8e-9, 0.26e-9, 1.2

    def places(depth, **values):
        light = direct_light(np.full((2, 1, 1), depth), np.diag([1e3, 1e3, 1]), None, np.ones((2, 1, 1)))
        light = replace(light, time_s=np.array([0.0, 0.3]))
        clock = Clock(width, 120, np.full(4, zero), two_piece_pulse(0.3e-9, 0.3e-9, width / 16))
        counts = ForwardModel(light, footprints(maps, (1, 1)), clock).expected(1.0, [effect.at(**values)])
        return counts @ (np.arange(120) + 0.5) / counts.sum(axis=-1)

    error = 0.02 + more.get("warmup", 0) * (1 - np.exp(-np.array([[0], [0.3]]) / 0.1)) + more.get("apart", 0)
    for depth in (0.6, 1.2, 2.0):
        closed = (zero + 2 * still / C + 2 * (depth - still) / C / (1 + error)) / width
        found = places(depth, error=0.02, still_at=still, **more)
        np.testing.assert_allclose(found, np.broadcast_to(closed, found.shape), atol=0.01)


def test_where_a_target_stays_is_asked_only_where_time_zero_was_estimated():
    sizes = {"zone": 4, "bin": 48}
    told, guessed = ({form.free for form in all_forms(sizes, guessed=one)} for one in (False, True))
    assert guessed - told == {("error", "still_at")}


def test_no_other_form_is_begun_with_a_target_that_stays(small):
    expected = ForwardModel(small.light, small.footprints, small.clock).expected(1e3)
    (start,) = effect.starts(0 * expected, expected, SimpleNamespace(light=small.light))
    assert 0 < start["still_at"] < 10
    begun = [form for form in all_forms({"zone": 4, "bin": 48}, guessed=True) if form.effect is effect]
    taken = {form.free for form in begun if form.beginning(start) is not None}
    assert taken == {("error", "still_at")}

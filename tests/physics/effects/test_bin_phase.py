"""Modulation by phase against a sum over pixels that modulates each by its own arrival, whatever the pulse's steps."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from physics.clock import Clock
from physics.effects.bin_phase import LEAST_PER_BIN, effect
from physics.effects.time_zero_offset import effect as offset
from physics.largest_share import largest_share
from physics.light import Return
from physics.nominal import ForwardModel
from physics.pulse import two_piece_pulse
from physics.rendering import Rendering
from tests.physics.conftest import C, slow_model


def by_pixel(light, weights, clock, depth, phase):
    """(F, P, T) at gain 1: each zone sees each pixel's strength times what the phase of its arrival makes of it."""
    direct, parts = light.returns[0], []
    for p, zero in enumerate(clock.time_zero_s):
        turns = (zero + 2 * direct.range_m.astype(float) / C) / clock.bin_width_s - phase
        lit = Return(direct.range_m, direct.strength * (1 + depth * np.cos(2 * np.pi * turns)))
        one = slow_model(
            replace(light, returns=(lit,)),
            weights[p : p + 1],
            clock.bin_width_s,
            clock.bins,
            clock.time_zero_s[p : p + 1],
            clock.pulse,
        )
        parts.append(one)
    return np.concatenate(parts, axis=1)


@pytest.mark.parametrize("per_bin", [1, 2, 3, 16, 40, 2.6])
def test_it_is_the_sum_over_pixels_however_coarse_the_pulse(small, per_bin):
    step = 0.26e-9 / per_bin
    clock = replace(small.clock, pulse=two_piece_pulse(0.3e-9, 0.5e-9, step))
    model = ForwardModel(small.light, small.footprints, clock)
    found = model.expected(1.0, [effect.at(depth=0.6, phase=0.1)])
    closed = by_pixel(small.light, small.footprints.weights, clock, 0.6, 0.1)
    np.testing.assert_allclose(found, closed, atol=0.6 * 5e-3 * closed.max())
    assert np.abs(model.expected() - closed).max() > 0.02 * closed.max()


def one_pixel(small, range_m, **values):
    """Counts of zone 0, whose every pixel is at one range."""
    strength = np.ones_like(small.light.returns[0].strength)
    light = replace(small.light, returns=(Return(np.full_like(strength, range_m), strength),))
    return ForwardModel(light, small.footprints, small.clock).expected(1.0, [effect.at(**values)])[0, 0].sum()


@pytest.mark.parametrize("phase", [0.0, 0.4])
def test_a_whole_pulse_goes_by_the_mean_arrival_of_its_light(small, phase):
    """Against a sum over pixels, whose weighted mean is that of each zone and frame."""
    # All light arrives within the window.
    clock, light, weights = replace(small.clock, bins=120), small.light, small.footprints.weights.reshape(4, -1)
    model = ForwardModel(light, small.footprints, clock, 5.0)
    found, nominal = (model.expected(10.0, [effect.at(whole=w, phase=phase)]) for w in (0.7, 0))
    for i in range(light.frames):
        direct = light.returns[0]
        for p in range(4):
            share = weights[p] * direct.strength[i].ravel()
            mean = clock.time_zero_s[p] + 2 / C * (share @ direct.range_m[i].ravel().astype(float)) / share.sum()
            times = 1 + 0.7 * np.cos(2 * np.pi * (mean / clock.bin_width_s - phase))
            np.testing.assert_allclose(found[i, p] - 5, times * (nominal[i, p] - 5), rtol=1e-4, atol=1e-9)


def test_a_sawtooth_has_harmonics(small):
    """Of a target that steps through one bin, by the sawtooth's Fourier series: sin(2πkφ)/k with alternating sign."""
    width = small.clock.bin_width_s
    phases = np.linspace(0, 1, 13)
    # The mean arrival of light at range r comes r / (c/2) after time zero.
    ranges = (3 * width + phases * width - small.clock.time_zero_s[0] % width) * C / 2
    values = {"phase": 0.25, "sin_2": 0.0, "cos_2": 0.5, "cos_3": -1 / 3}
    plain, seen = (np.array([one_pixel(small, r, whole=w, **values) for r in ranges]) for w in (0.0, 0.3))
    turned = 2 * np.pi * (phases - 0.25)
    wanted = 1 + 0.3 * (np.cos(turned) + np.cos(2 * turned) / 2 - np.cos(3 * turned) / 3)
    np.testing.assert_allclose(seen / plain, wanted, rtol=2e-3)


def test_a_dark_zone_has_no_mean_arrival(small):
    weights = small.footprints.changed(lambda w: w * np.array([1, 0, 1, 1])[:, None, None])
    found = ForwardModel(small.light, weights, small.clock, 5.0).expected(1.0, [effect.at(whole=1)])
    np.testing.assert_allclose(found[:, 1], 5)


def test_a_target_that_steps_through_a_bin_comes_back(small):
    width, zero = small.clock.bin_width_s, small.clock.time_zero_s[0]
    plain = one_pixel(small, 0.5, depth=0)
    for turns in (0.0, 0.2, 0.5, 0.83):
        for bins in (12, 20):
            range_m = ((bins + turns) * width - zero) * C / 2
            found = one_pixel(small, range_m, depth=0.4, phase=0.2) / plain
            assert found == pytest.approx(1 + 0.4 * np.cos(2 * np.pi * (turns - 0.2)), abs=3e-3)


def test_at_full_depth_the_worst_phase_counts_nothing(small):
    zero, width = small.clock.time_zero_s[0], small.clock.bin_width_s
    dark = one_pixel(small, ((12 + 0.5) * width - zero) * C / 2, depth=1, phase=0)
    assert 0 <= dark < 5e-3 * one_pixel(small, 0.5, depth=0)


def test_a_delay_moves_the_phase_by_as_much(small):
    """Half a bin later the best phase is the worst."""
    width, clock = small.clock.bin_width_s, replace(small.clock, bins=120)
    model = ForwardModel(small.light, small.footprints, clock)
    late = model.expected(1.0, [offset.at(delay=width / 2), effect.at(depth=0.5, phase=0.75)])
    early = model.expected(1.0, [effect.at(depth=0.5, phase=0.25)])
    np.testing.assert_allclose(late.sum(axis=-1), early.sum(axis=-1), rtol=1e-6)


def test_background_and_light_of_all_phases_stay(small):
    count = small.light.range_m.size
    even = np.linspace(0.4, 0.4 + 8 * small.clock.bin_width_s * C / 2, count, endpoint=False)
    shape = small.light.range_m.shape
    ranges = np.random.default_rng(6).permutation(even).reshape(shape).astype(np.float32)
    light = replace(small.light, returns=(Return(ranges, np.ones(shape, np.float32)),))
    level = small.footprints.changed(np.ones_like)
    model = ForwardModel(light, level, small.clock, 5.0)
    found, nominal = (model.expected(1.0, [effect.at(depth=d)]) for d in (0.8, 0))
    np.testing.assert_allclose((found - 5).sum(axis=(0, 2)), (nominal - 5).sum(axis=(0, 2)), rtol=2e-3)
    dark = replace(small.light, returns=(Return(ranges, np.zeros(shape, np.float32)),))
    assert (ForwardModel(dark, small.footprints, small.clock, 5.0).expected(1.0, [effect.at(depth=1)]) == 5).all()


@given(st.integers(1, 60))
def test_the_lattice_is_fine_enough(per_bin):
    clock = Clock(1e-9, 8, np.zeros(1), two_piece_pulse(1e-9, 2e-9, 1e-9 / per_bin))
    found = effect.clock(effect.at(depth=0.1).values, SimpleNamespace(clock=clock)).lattice
    assert found.per_bin % per_bin == 0
    assert LEAST_PER_BIN <= found.per_bin < max(2 * LEAST_PER_BIN, per_bin + 1)
    assert effect.clock(effect.vanished().values, SimpleNamespace(clock=clock)) is clock


def test_each_zone_may_have_a_depth_of_its_own(small):
    model, depths = ForwardModel(small.light, small.footprints, small.clock), np.array([0.6, 0, 0.3, 1.0])
    for name in ("depth", "whole"):
        found = model.expected(1e3, [effect.at(**{name: depths, "phase": 0.2})])
        for zone, depth in enumerate(depths):
            alone = model.expected(1e3, [effect.at(**{name: depth, "phase": 0.2})])
            np.testing.assert_allclose(found[:, zone], alone[:, zone], atol=2e-3 * alone.max())


def test_each_zone_may_have_a_phase_of_its_own(small):
    """A cosine and a sine are a cosine of another phase."""
    model = ForwardModel(small.light, small.footprints, small.clock)
    depths, phases = np.array([0.6, 0.1, 0.3, 0.9]), np.array([0.2, 0.9, 0.5, 0.7])
    along, across = depths * np.cos(2 * np.pi * phases), depths * np.sin(2 * np.pi * phases)
    found = model.expected(1e3, [effect.at(along=along, across=across)])
    for zone, (depth, phase) in enumerate(zip(depths, phases, strict=True)):
        alone = model.expected(1e3, [effect.at(whole=depth, phase=phase)])
        np.testing.assert_allclose(found[:, zone], alone[:, zone], rtol=1e-9)


@pytest.mark.parametrize("step", [0.05e-9, 0.26e-9, 0.7e-9])
def test_the_largest_share_is_that_of_the_bins(step):
    """Against a pulse put into bins at each place, wherever its own steps begin."""
    pulse, width = two_piece_pulse(0.3e-9, 0.5e-9, step), 0.26e-9
    found = largest_share(pulse, width)
    for i in (0, 7, 33, 63):
        arrival = (20 + i / len(found)) * width
        assert found[i] == pytest.approx(pulse.in_bins(np.array([arrival]), 60, width).max(), abs=1e-12)


def test_light_counts_by_the_largest_bins_part(small):
    """By histograms without it, zone by zone and frame by frame."""
    model = ForwardModel(small.light, small.footprints, small.clock)
    plain = model.expected(1e3)
    alone = largest_share(small.clock.pulse, small.clock.bin_width_s).mean()
    times = (plain.max(axis=2) / plain.sum(axis=2) / alone) ** 0.7
    assert np.ptp(times) > 0.05
    found = model.expected(1e3, [effect.at(peaked=0.7, depth=0.0)])
    np.testing.assert_allclose(found, plain * times[..., None], rtol=1e-9)


def test_maps_that_were_read_off_the_largest_bin_hold_rings(small):
    """Each pixel's map over the largest bin of a pulse from the plane of the scan, by its zone's own time zero."""
    values = effect.at(ringed=1.5, taken_at=0.6).values
    rendering = Rendering(small.light, small.footprints, small.clock, 1.0)
    found = effect.footprints(values, rendering).weights
    v, u = 5, 8
    ray = np.linalg.norm(small.light.rays[v, u])
    shares = largest_share(small.clock.pulse, small.clock.bin_width_s)
    for p, zero in enumerate(small.clock.time_zero_s):
        turn = (zero + 2 * 0.6 * ray / C) / small.clock.bin_width_s % 1
        there = np.interp(turn * len(shares), np.arange(len(shares) + 1), [*shares, shares[0]])
        divided = small.footprints.weights[p, v, u] * (shares.mean() / there) ** 1.5
        assert found[p, v, u] == pytest.approx(divided, rel=1e-5)
    assert effect.footprints(effect.at(ringed=1.0).values, rendering) is small.footprints


@pytest.mark.parametrize("about", [1.0, 3.0])
def test_a_whole_pulse_may_go_by_the_centroid_about_its_highest_bin(small, about):
    """Of what is beyond the background, which stays; all of the signal by one factor, each bin weighted by hand."""
    model = ForwardModel(small.light, small.footprints, small.clock, np.array([3.0, 5, 0, 9]))
    plain, dark = model.expected(1e3), np.array([3.0, 5, 0, 9])[:, None]
    found = model.expected(1e3, [effect.at(whole=0.3, phase=0.2, about=about)])
    for frame, zone in np.ndindex(plain.shape[:2]):
        signal = plain[frame, zone] - dark[zone]
        top = int(np.argmax(signal))
        bins = np.arange(max(top - int(about), 0), min(top + int(about) + 1, len(signal)))
        turns = np.average(bins + 0.5, weights=signal[bins]) - 0.2
        wanted = dark[zone] + signal * (1 + 0.3 * np.cos(2 * np.pi * turns))
        np.testing.assert_allclose(found[frame, zone], wanted, rtol=1e-9)


def test_less_than_a_bin_beside_the_highest_tells_in_part(small):
    """One smooth way from the mean of all light, at 0, to the centroid of the highest bin, at 1."""
    model = ForwardModel(small.light, small.footprints, small.clock, np.zeros(4))
    all_of_it, barely, half = (
        model.expected(1e3, [effect.at(whole=0.3, phase=0.2, about=about)]) for about in (0.0, 1e-9, 0.5)
    )
    np.testing.assert_allclose(barely, all_of_it, rtol=1e-6)
    assert np.abs(half - all_of_it).max() > 1

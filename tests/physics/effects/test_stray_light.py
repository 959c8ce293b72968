"""Stray light against the sum of the zones' own histograms, on clocks whose zones differ by nothing or a bin."""

from dataclasses import replace

import numpy as np

from physics.effects.cover_glass_crosstalk import effect as crosstalk
from physics.effects.stray_light import effect
from physics.nominal import ForwardModel
from physics.pulse import ImpulseResponse
from tests.physics.conftest import slow_model


def model_at(small, time_zero_s, footprints=None):
    clock = replace(small.clock, time_zero_s=np.array(time_zero_s))
    return ForwardModel(small.light, footprints or small.footprints, clock, 5.0)


def test_each_zone_gets_a_share_of_the_sum_of_all(small):
    model, share = model_at(small, [2e-9] * 4), np.array([0, 0.01, 0.1, 1])
    signal = model.expected(1e3) - 5
    more = model.expected(1e3, [effect.at(share=share)]) - model.expected(1e3)
    np.testing.assert_allclose(more, share[:, None] * signal.sum(axis=1, keepdims=True), atol=1e-9)


def test_a_blind_zone_sees_what_the_others_see_by_its_own_clock(small):
    blind = small.footprints.changed(lambda weights: weights * np.array([1, 1, 1, 0])[:, None, None])
    model = model_at(small, [2e-9, 2e-9, 2e-9, 2e-9 + small.clock.bin_width_s], blind)
    found = model.expected(1e3, [effect.at(share=[0, 0, 0, 0.2])]) - 5
    np.testing.assert_allclose(found[:, 3, 1:], 0.2 * found[:, :3].sum(axis=1)[:, :-1], atol=1e-9)


def test_a_response_in_coarse_steps_does_not_become_wider_from_clock_to_clock(small):
    """What each zone gets is what all together register by its own clock."""
    pulse = ImpulseResponse(small.clock.bin_width_s / 2 * np.arange(4), np.array([0.2, 0.5, 0.2, 0.1]))
    small.clock, zeros = replace(small.clock, pulse=pulse), np.array([2.0, 2.033, 2.151, 1.97]) * 1e-9
    model = model_at(small, zeros)
    more = model.expected(1e3, [effect.at(share=0.1)]) - model.expected(1e3)
    wanted = [0.1 * (model_at(small, [zero] * 4).expected(1e3) - 5).sum(axis=1) for zero in zeros]
    np.testing.assert_allclose(more, np.stack(wanted, axis=1), atol=1e-2 * more.max())


def test_what_mixes_after_it_was_timed_keeps_its_time(small):
    zeros = np.array([2.0, 2.3, 2.9, 3.4]) * 1e-9
    model = model_at(small, zeros)
    signal = model.expected(1e3) - 5
    more = model.expected(1e3, [effect.at(share=0.1, clocks=1)]) - model.expected(1e3)
    np.testing.assert_allclose(more, np.broadcast_to(0.1 * signal.sum(axis=1, keepdims=True), more.shape), atol=1e-9)
    half, none = (model.expected(1e3, [effect.at(share=0.1, clocks=c)]) - model.expected(1e3) for c in (0.5, 0))
    np.testing.assert_allclose(half, (more + none) / 2, atol=1e-9)
    assert np.abs(more - none).max() > 1


def test_crosstalk_is_no_light_of_the_field(small):
    model = model_at(small, [2e-9] * 4)
    both = model.expected(1e3, [crosstalk.at(), effect.at()])
    apart = model.expected(1e3, [crosstalk.at()]) + model.expected(1e3, [effect.at()]) - model.expected(1e3)
    np.testing.assert_allclose(both, apart, atol=1e-9)


def test_glare_comes_from_all_over_the_field(small):
    """Pixel by pixel: what each sends, times the bell over the field, in every zone that has glare."""
    model = ForwardModel(small.light, small.footprints, small.clock)
    glare = np.array([0.02, 0, 0.1, 0.05])
    found = model.expected(1.0, [effect.at(share=0.0, glare=glare, glare_x=0.4, glare_y=0.2)]) - model.expected(1.0)
    bell = np.zeros((6, 10))
    for v, u in np.ndindex(bell.shape):
        x, y = (u - 4.5) / 7.5, (v - 2.5) / 7.5
        bell[v, u] = np.exp(-(x**2) / 0.32 - y**2 / 0.08)
    weights = glare[:, None, None] * bell
    clock = small.clock
    closed = slow_model(small.light, weights, clock.bin_width_s, clock.bins, clock.time_zero_s, clock.pulse)
    np.testing.assert_allclose(found, closed, atol=1e-5 * closed.max())

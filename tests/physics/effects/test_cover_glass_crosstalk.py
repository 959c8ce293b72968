"""Crosstalk against the pulse itself, placed in bins by its cumulative."""

from dataclasses import replace

import numpy as np
import pytest

from physics.effects.cover_glass_crosstalk import effect
from physics.nominal import ForwardModel
from physics.rendering import Rendering
from recordings.refusal import Refusal

CYCLES = 2e4


@pytest.mark.parametrize("gain", [1.0, 3e3])
def test_it_is_one_pulse_near_time_zero_whatever_the_gain(small, gain):
    model = ForwardModel(small.light, small.footprints, small.clock)
    share, delay = np.array([0, 1e-3, 2e-3, 3e-3]), 0.5e-9
    found = model.expected(gain, [effect.at(share=share, delay=delay)]) - model.expected(gain)
    clock = small.clock
    pulses = clock.pulse.in_bins(clock.time_zero_s + delay, clock.bins, clock.bin_width_s)
    closed = (CYCLES * share)[:, None] * pulses
    np.testing.assert_allclose(found, np.broadcast_to(closed, found.shape), atol=2e-3 * closed.max())


def test_all_its_counts_are_there_and_go_with_the_shots(small):
    light = replace(small.light, laser_cycles=np.array([1e4, 2e4, 4e4]))
    model = ForwardModel(light, small.footprints, small.clock)
    more = (model.expected(10.0, [effect.at(share=1e-3)]) - model.expected(10.0)).sum(axis=-1)
    np.testing.assert_allclose(more, np.repeat([[10.0], [20], [40]], 4, axis=1), rtol=1e-4)


def test_no_target_moves_it(small):
    dark = replace(small.light.returns[0], strength=np.zeros_like(small.light.returns[0].strength))
    empty = ForwardModel(replace(small.light, returns=(dark,)), small.footprints, small.clock)
    model = ForwardModel(small.light, small.footprints, small.clock)
    more = model.expected(10.0, [effect.at()]) - model.expected(10.0)
    np.testing.assert_allclose(empty.expected(10.0, [effect.at()]), more, atol=1e-9)


def test_it_asks_for_shots_and_gain(small):
    unknown = replace(small.light, laser_cycles=None)
    with pytest.raises(Refusal, match="laser_cycles is missing"):
        ForwardModel(unknown, small.footprints, small.clock).expected(1.0, [effect.at()])
    with pytest.raises(Refusal, match="gain is 0, expected above 0"):
        ForwardModel(small.light, small.footprints, small.clock).expected(0.0, [effect.at()])


def test_where_nobody_knows_the_shots_it_is_counts_in_a_frame(small):
    unknown = replace(small.light, laser_cycles=None)
    model = ForwardModel(unknown, small.footprints, small.clock)
    counts = [0.0, 7.0, 30.0, 2.0]
    more = model.expected(10.0, [effect.at(counts=counts, delay=-1e-10)]) - model.expected(10.0)
    np.testing.assert_allclose(more.sum(axis=-1), np.broadcast_to(counts, (3, 4)), rtol=1e-4, atol=1e-6)
    shots = ForwardModel(small.light, small.footprints, small.clock)
    by_shot = [effect.at(share=np.array(counts) / CYCLES, delay=-1e-10)]
    np.testing.assert_allclose(shots.expected(10.0, by_shot) - shots.expected(10.0), more, atol=1e-9)


def test_ways_that_take_differing_times_make_a_longer_pulse(small):
    """Against the mean of pulses at delays that a normal density weights."""
    model, sigma, nodes = ForwardModel(small.light, small.footprints, small.clock), 2e-10, np.linspace(-5, 5, 201)
    weights = np.exp(-(nodes**2) / 2)
    # Limits of a parameter do not bind an oracle.
    each = [more_at(small, 3e-10 + sigma * node) for node in nodes]
    found = model.expected(10.0, [effect.at(counts=50.0, delay=3e-10, longer=sigma)]) - model.expected(10.0)
    wanted = np.tensordot(weights / weights.sum(), each, axes=1)
    np.testing.assert_allclose(found, np.broadcast_to(wanted, found.shape), atol=4e-3 * wanted.max())


def test_light_that_is_thrown_to_and_fro_leaves_a_trail(small):
    """Against the mean of pulses at delays that an exponential density weights."""
    model, trail = ForwardModel(small.light, small.footprints, small.clock), 4e-10
    nodes = (np.arange(4000) + 0.5) / 200
    weights = np.exp(-nodes)
    wanted = np.tensordot(weights / weights.sum(), [more_at(small, 1e-10 + trail * node) for node in nodes], axes=1)
    found = model.expected(10.0, [effect.at(counts=50.0, delay=1e-10, trail=trail)]) - model.expected(10.0)
    np.testing.assert_allclose(found, np.broadcast_to(wanted, found.shape), atol=6e-3 * wanted.max())


def test_it_may_arrive_at_one_time_by_the_clock(small):
    model, clock = ForwardModel(small.light, small.footprints, small.clock), small.clock
    found = model.expected(10.0, [effect.at(counts=50.0, delay=3e-10, together=1)]) - model.expected(10.0)
    at = np.full(4, clock.time_zero_s.mean() + 3e-10)
    wanted = 50 * clock.pulse.in_bins(at, clock.bins, clock.bin_width_s)
    np.testing.assert_allclose(found, np.broadcast_to(wanted, found.shape), atol=4e-3 * wanted.max())


def more_at(small, delay):
    """(P, T) counts of 50 that arrive so long after time zero."""
    clock = small.clock
    return 50 * clock.pulse.in_bins(clock.time_zero_s + delay, clock.bins, clock.bin_width_s)


def test_it_grows_as_the_glass_gets_dirty(small):
    model = ForwardModel(small.light, small.footprints, small.clock)
    for growth, times in ((3.0, [1, 1.3, 1.6]), (-1.0, [1, 0.9, 0.8])):
        one, more = (
            model.expected(10.0, [effect.at(counts=50.0, growth=g)]) - model.expected(10.0) for g in (0.0, growth)
        )
        np.testing.assert_allclose(more, one * np.reshape(times, (3, 1, 1)), atol=1e-9)


@pytest.mark.parametrize("delay", [-1.2e-10, 7e-10])
def test_it_suggests_the_delay(small, delay):
    model = ForwardModel(small.light, small.footprints, small.clock, 2.0)
    truth, nominal = effect.at(counts=[300.0, 0, 90, 20], delay=delay), model.expected(1e3)
    excess = np.random.default_rng(3).poisson(model.expected(1e3, [truth])) - nominal
    starts = effect.starts(excess, nominal, Rendering(small.light, small.footprints, small.clock, 1e3, background=2.0))
    assert abs(starts[0]["delay"] - delay) < small.clock.bin_width_s / 3


def test_a_second_way_is_a_second_pulse(small):
    """As two effects of one pulse each would add up."""
    model = ForwardModel(small.light, small.footprints, small.clock)

    def inside(**values):
        return model.expected(1e3, [effect.at(**values)]) - model.expected(1e3)

    found = inside(counts=200.0, delay=-1e-10, again=0.4, again_later=6e-10)
    np.testing.assert_allclose(found, inside(counts=200.0, delay=-1e-10) + inside(counts=80.0, delay=5e-10), atol=1e-6)

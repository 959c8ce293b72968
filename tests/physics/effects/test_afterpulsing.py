"""The echo against afterpulses drawn one by one, and against the geometric series."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import expon, genpareto

from physics.effects.afterpulsing import effect
from physics.nominal import ForwardModel

WIDTH = 0.4e-9


def seen(counts, **values):
    clock = SimpleNamespace(bin_width_s=WIDTH)
    start = SimpleNamespace(expected=np.asarray(counts, float), clock=clock, background=0.0)
    return effect.expected(effect.at(**values).values, start)


def test_events_drawn_one_by_one_agree():
    rng = np.random.default_rng(8)
    events, tau, share = 400_000, 1.3e-9, 0.3
    primary = rng.choice([4, 5, 20], events, p=[0.5, 0.3, 0.2])
    followed = primary[rng.random(events) < share]
    # A delay begun but not over counts as a whole bin: the next bins are 1, 2, ... away.
    later = followed + np.ceil(rng.exponential(tau, followed.size) / WIDTH).astype(int)
    drawn = np.bincount(np.concatenate([primary, later[later < 60]]), minlength=60)
    expected = seen(np.bincount(primary, minlength=60), probability=share, tau=tau)
    assert (np.abs(drawn - expected) < 5 * np.sqrt(expected) + 1e-9).all()


@given(probability=st.floats(0, 1), tau=st.floats(1e-9, 1e-8))
def test_one_pulse_is_followed_by_a_geometric_series(probability, tau):
    counts = np.zeros(1000)
    counts[7] = 1000
    found = seen(counts, probability=probability, tau=tau)
    np.testing.assert_allclose(found[:8], counts[:8])
    ratio = np.exp(-WIDTH / tau)
    np.testing.assert_allclose(found[8:40], 1000 * probability * (1 - ratio) * ratio ** np.arange(32), atol=1e-9)
    np.testing.assert_allclose(found.sum(), 1000 * (1 + probability), rtol=1e-9)


@pytest.mark.parametrize("dead", [-0.4e-9, -0.1e-9, 0.0, 0.1e-9, 0.4e-9, 1.7e-9, 1e-8])
def test_none_is_released_in_the_hold_off(dead):
    """Shares of an exponential distribution that begins so late, bin by bin."""
    tau, counts = 1.3e-9, np.zeros(60)
    counts[5] = 1000
    found = seen(counts, probability=0.4, tau=tau, dead=dead) - counts
    edges = (np.arange(61) - 6) * WIDTH
    np.testing.assert_allclose(found, 400 * np.diff(expon.cdf(edges, loc=dead, scale=tau)), atol=1e-9)


def test_traps_of_two_kinds_add_their_echoes():
    counts = np.zeros(60)
    counts[5] = 1000
    both = seen(counts, probability=0.2, tau=1.3e-9, dead=0.3e-9, slower=0.1, times=5) - counts
    fast = seen(counts, probability=0.2, tau=1.3e-9, dead=0.3e-9) - counts
    slow = seen(counts, probability=0.1, tau=6.5e-9, dead=0.3e-9) - counts
    np.testing.assert_allclose(both, fast + slow, atol=1e-12)


def test_background_that_has_its_afterpulses_is_given_none(small):
    """Of a scene and its background: as if afterpulses were made of the scene alone, and the background added then."""
    dark = ForwardModel(small.light, small.footprints, small.clock, 0.0)
    found = ForwardModel(small.light, small.footprints, small.clock, 7.0).expected(1e3, [effect.at(ambient=0.0)])
    np.testing.assert_allclose(found, dark.expected(1e3, [effect.at()]) + 7.0)


def test_it_may_begin_with_light_alone_where_there_is_background():
    lit, dark = (SimpleNamespace(background=np.full((4, 1), level)) for level in (3.0, 0.0))
    begun = effect.starts(None, None, lit)
    assert {one["ambient"] for one in begun} == {0.0}
    assert [one["tau"] for one in begun] == list(effect.parameter("tau").tries)
    assert effect.starts(None, None, dark) == []


def test_background_of_before_the_window_is_followed_by_as_much_as_falls():
    """Constant light, whose events are followed by as many afterpulses a bin as by any, from whenever they are."""
    clock = SimpleNamespace(bin_width_s=WIDTH)
    start = SimpleNamespace(expected=np.full((2, 3, 50), 5.0), clock=clock, background=np.full((3, 1), 5.0))
    for heavy in (0.0, 1.5):
        values = {"probability": 0.2, "tau": 3e-9, "dead": 1e-9, "slower": 0.1, "times": 5, "heavy": heavy}
        found = effect.expected(effect.at(**values, earlier=1.0).values, start)
        np.testing.assert_allclose(found, 5 * 1.3)
        part = effect.expected(effect.at(**values, earlier=0.4).values, start)
        np.testing.assert_allclose(part, 0.6 * effect.expected(effect.at(**values).values, start) + 0.4 * found)


def test_events_of_later_cycles_come_at_any_time_in_them():
    """In a bin as many as an event in any bin has there, each of which is as likely."""
    counts = np.random.default_rng(5).uniform(0, 90, 60)
    without = seen(counts, probability=0.2, tau=1.3e-9)
    deep = seen(counts, probability=0.2, tau=1.3e-9, deep=0.1) - without
    np.testing.assert_allclose(deep, sum(0.1 * count / 60 for count in counts))


def test_it_is_in_proportion_to_the_pulse(small):
    model = ForwardModel(small.light, small.footprints, small.clock)
    one, ten = model.expected(1.0, [effect.at()]), model.expected(10.0, [effect.at()])
    np.testing.assert_allclose(ten, 10 * one)


@pytest.mark.parametrize(("tau", "dead", "quick"), [(1e-9, 0.0, True), (1e-9, 2 * WIDTH, False), (3e-9, 0.0, False)])
def test_an_echo_at_once_is_rather_a_tail(tau, dead, quick):
    rendering = SimpleNamespace(clock=SimpleNamespace(bin_width_s=WIDTH))
    assert effect.strained(effect.at(probability=0.1, tau=tau, dead=dead).values, rendering) == quick
    assert not effect.strained(effect.at(probability=0.0, tau=tau, dead=dead).values, rendering)


@pytest.mark.parametrize(("heavy", "dead"), [(0.5, 0.0), (2.0, 0.7e-9), (1e-5, 0.2e-9)])
def test_traps_of_many_depths_release_by_a_power_law(heavy, dead):
    """Shares of a generalised Pareto distribution, bin by bin."""
    tau, counts = 1.3e-9, np.zeros(60)
    counts[5] = 1000
    found = seen(counts, probability=0.4, tau=tau, dead=dead, heavy=heavy) - counts
    edges = (np.arange(61) - 6) * WIDTH
    np.testing.assert_allclose(found, 400 * np.diff(genpareto.cdf(edges, heavy, loc=dead, scale=tau)), atol=1e-9)


def test_a_tail_that_is_hardly_heavy_is_exponential():
    counts = np.random.default_rng(1).random(60)
    light, heavy = (seen(counts, probability=0.4, tau=1.3e-9, heavy=value) for value in (0.0, 2e-6))
    np.testing.assert_allclose(heavy, light, atol=1e-6)


def test_zones_may_have_traps_of_their_own(small):
    model, probabilities = ForwardModel(small.light, small.footprints, small.clock, 3.0), np.array([0.4, 0.1, 0, 0.3])
    found = model.expected(1e3, [effect.at(probability=probabilities, tau=2e-9)])
    for zone, probability in enumerate(probabilities):
        alone = model.expected(1e3, [effect.at(probability=probability, tau=2e-9)])
        np.testing.assert_allclose(found[:, zone], alone[:, zone])

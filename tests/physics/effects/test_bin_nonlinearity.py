"""Unequal bins against the code-density test, and against a pulse integrated between the displaced edges."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import norm

from physics.effects import find_effect
from physics.effects.bin_nonlinearity import effect
from physics.nominal import ForwardModel
from physics.rendering import Rendering


def seen(counts, **values):
    return effect.expected(effect.at(**values).values, SimpleNamespace(expected=np.asarray(counts, float)))


def test_a_pedestal_shows_the_widths():
    """The code-density test: counts of constant light are in proportion to the width of their bin."""
    found = seen(np.full((2, 3, 40), 100.0), alternation=0.1, slope=0)
    np.testing.assert_allclose(found[..., 1:-1:2], 120)
    np.testing.assert_allclose(found[..., 2:-1:2], 80)
    bent = seen(np.full(200, 100.0), alternation=0, slope=0.1)
    np.testing.assert_allclose(bent, 100 + 10 * np.cos(np.pi * (np.arange(200) + 0.5) / 200), atol=1e-2)


def test_a_wave_prints_its_slope_on_a_pedestal():
    """An edge at t + a·sin(2πt/T) makes bins as much wider as the wave rises from edge to edge: 2a·sin(π/T) at most."""
    found = seen(np.full(90, 100.0), wave_sin=0.3, period=9.0)
    middle = np.arange(90) + 0.5
    closed = 100 * (1 + 2 * 0.3 * np.sin(np.pi / 9) * np.cos(2 * np.pi * middle / 9))
    np.testing.assert_allclose(found, closed, rtol=1e-9)
    np.testing.assert_allclose(
        seen(np.full(90, 1.0), wave_cos=0.2, period=9.0)[1:-1],
        seen(np.full(90, 1.0), edge=0.2 * np.cos(2 * np.pi * np.arange(90) / 9) - 0.2)[1:-1],
    )


def test_taps_come_again_every_eighth_bin_and_add_up():
    """Widths of a delay line as they are told, on a pedestal; a pulse is what it has between their sums."""
    taps = np.array([0, 0.1, -0.2, 0.3, 0, 0, -0.4, 0.05])
    named = {f"tap_{k}": taps[k] for k in range(1, 8)}
    width = 1 + np.tile(taps - taps.mean(), 6)
    np.testing.assert_allclose(seen(np.full(48, 10.0), **named), 10 * width)
    pulse, edges = norm(20.3, 2.5), np.concatenate([[0], np.cumsum(width)])
    found = seen(np.diff(pulse.cdf(np.arange(49))), **named)
    np.testing.assert_allclose(found, np.diff(pulse.cdf(edges)), atol=5e-3 * found.max())


def test_bins_that_are_wider_in_place_hold_their_own_counts_times_their_width():
    counts = np.random.default_rng(2).exponential(size=(2, 3, 36))
    waved = seen(counts, wave_sin=1.2, period=12.0, moved=0)
    number = np.arange(36)
    closed = 1 + 1.2 * (np.sin(np.pi * (number + 1) / 6) - np.sin(np.pi * number / 6))
    np.testing.assert_allclose(waved, counts * closed)
    half = seen(counts, wave_sin=1.2, period=12.0, moved=0.5)
    np.testing.assert_allclose(half, (waved + seen(counts, wave_sin=1.2, period=12.0)) / 2)
    own = np.linspace(-0.5, 0.7, 36)
    np.testing.assert_allclose(seen(counts, width=own), counts * (1 + own))


@pytest.mark.parametrize("moved", [1.0, 0.0])
@pytest.mark.parametrize("period", [5.3, 11.0, 37.0])
def test_a_wave_of_any_period_is_found(moved, period):
    """A pulse that wanders over the window: where a fit should begin is within a fringe of the truth."""
    at = np.linspace(20, 100, 40)[:, None, None]
    counts = 3 + 4000 * np.diff(norm(at, 3.0).cdf(np.arange(129)), axis=-1)
    depth = 0.02 * period
    found = seen(counts, wave_sin=depth, wave_cos=-depth, period=period, moved=moved)
    excess = np.random.default_rng(1).poisson(found) - counts
    starts = {start["moved"]: start["period"] for start in effect.starts(excess, counts, None)}
    assert abs(1 / starts[moved] - 1 / period) < 1 / 128


@pytest.mark.parametrize(("alternation", "slope"), [(0.3, 0), (-0.2, 0.1), (0, -0.15)])
def test_a_pulse_is_integrated_between_the_displaced_edges(alternation, slope):
    edges = np.arange(61.0)
    pulse = norm(30.3, 3.0)
    late = np.where(edges % 2 == 0, alternation, -alternation)
    moved = edges + late + slope * 60 / np.pi * np.sin(np.pi * edges / 60)
    found = seen(np.diff(pulse.cdf(edges)), alternation=alternation, slope=slope)
    np.testing.assert_allclose(found, np.diff(pulse.cdf(moved)), atol=5e-3 * found.max())


def test_bins_of_unequal_width_hold_counts_in_proportion_to_it():
    width = np.random.default_rng(3).uniform(0.9, 1.1, 30)
    edges = np.concatenate([[0], np.cumsum(width)])
    edges *= 30 / edges[-1]
    found = seen(np.full((2, 30), 50.0), edge=edges[:-1] - np.arange(30))
    np.testing.assert_allclose(found, np.broadcast_to(50 * np.diff(edges), (2, 30)), rtol=1e-9)


def test_signal_is_what_the_pulse_has_between_displaced_edges(small):
    """One pixel at a time, with the pulse's own cumulative: exact at knots, within a step between them."""
    clock, rng = small.clock, np.random.default_rng(4)
    edge = rng.uniform(-0.4, 0.4, clock.bins)
    model = ForwardModel(small.light, small.footprints, clock, 3.0)
    found = model.expected(1e3, [effect.at(edge=edge)])
    edges = np.append(np.arange(clock.bins) + edge, clock.bins) * clock.bin_width_s
    edges[0] = 0
    (_, weights), direct = small.footprints.seen[0], small.light.returns[0]
    pixels = small.footprints.seen[0][0]
    ranges, strength = (a.reshape(3, -1)[:, pixels] for a in (direct.range_m, direct.strength))
    closed = np.zeros_like(found)
    for p in range(4):
        until = clock.pulse.cumulative(edges - clock.time_zero_s[p] - 2 * ranges[..., None] / 299_792_458)
        closed[:, p] = np.einsum("fu,fut->ft", 1e3 * strength * weights[:, p], np.diff(until, axis=-1))
    closed += 3 * np.diff(edges) / clock.bin_width_s
    np.testing.assert_allclose(found, closed, atol=1e-3 * closed.max())


def test_only_the_two_bins_beside_an_edge_change_and_edge_0_stays(small):
    model = ForwardModel(small.light, small.footprints, small.clock)
    nominal = model.expected(1e3)
    late = effect.at(edge=np.where(np.arange(40) == 22, 0.3, 0.0))
    changed = np.abs(model.expected(1e3, [late]) - nominal).max(axis=(0, 1)) > 1e-9 * nominal.max()
    assert np.flatnonzero(changed).tolist() == [21, 22]
    first = effect.at(edge=np.where(np.arange(40) == 0, 0.5, 0.0))
    np.testing.assert_allclose(model.expected(1e3, [first]), nominal, rtol=1e-12)


def test_edges_that_would_change_places_meet():
    edge = np.where(np.arange(20) == 9, 0.5, np.where(np.arange(20) == 10, -0.5, 0.0))
    found = seen(np.full(20, 8.0), edge=edge, alternation=-0.4)
    assert found[9] == 0
    np.testing.assert_allclose(found.sum(), 160)


@given(
    alternation=st.floats(-0.4, 0.4),
    slope=st.floats(-0.15, 0.15),
    edge=st.floats(0, 0.5),
    bins=st.integers(2, 60),
    seed=st.integers(0, 999),
)
def test_counts_are_kept_and_none_turns_negative(alternation, slope, edge, bins, seed):
    counts = np.random.default_rng(seed).exponential(size=(2, 3, bins)) ** 4
    late = edge * (-1) ** (np.arange(bins) // 3)
    found = seen(counts, alternation=alternation, slope=slope, edge=late)
    np.testing.assert_allclose(found.sum(axis=-1), counts.sum(axis=-1))
    assert (found >= 0).all()


@pytest.mark.parametrize(("period", "stretched"), [(8.0, False), (19.0, False), (21.0, True), (100.0, True)])
def test_a_wave_that_comes_once_is_no_pattern(small, period, stretched):
    rendering = Rendering(small.light, small.footprints, small.clock, 1.0)
    assert small.clock.bins == 40
    assert effect.strained(effect.at(wave_cos=0.3, period=period).values, rendering) == stretched
    assert not effect.strained(effect.at(alternation=0.1, period=period).values, rendering)


@pytest.mark.parametrize(("of_zones", "of_all"), [("zone_edge", "edge"), ("zone_width", "width")])
def test_each_zone_may_have_a_converter_of_its_own(small, of_zones, of_all):
    """Zone by zone, as if all had that zone's; beside what they share, and with a background that is not flat."""
    rng, bins = np.random.default_rng(6), small.clock.bins
    own = rng.uniform(-0.3, 0.3, (4, bins))
    model, pedestal = ForwardModel(small.light, small.footprints, small.clock, 3.0), find_effect("afterpulsing").at()
    found = model.expected(1e3, [pedestal, effect.at(**{of_zones: own.ravel(), "alternation": 0.1})])
    for zone in range(4):
        alone = model.expected(1e3, [pedestal, effect.at(**{of_all: own[zone], "alternation": 0.1})])
        np.testing.assert_allclose(found[:, zone], alone[:, zone], rtol=1e-9)
    alike = model.expected(1e3, [effect.at(**{of_zones: 0.05})])
    np.testing.assert_allclose(alike, model.expected(1e3, [effect.at(**{of_all: 0.05})]), rtol=1e-9)


@pytest.mark.parametrize(("gains", "stretched"), [(0.0, False), (0.3, True)])
def test_bins_that_are_wide_together_are_a_brighter_zone(small, gains, stretched):
    """Those that nobody saw are as wide as they were taken to be, and say nothing either way."""
    rng = np.random.default_rng(1)
    wider = rng.normal(0, 0.05, (4, 40)) + np.linspace(-gains, gains, 4)[:, None]
    wider[:, 15:] = 0.0
    rendering = Rendering(small.light, small.footprints, small.clock, 1.0)
    assert effect.strained(effect.at(zone_width=wider.ravel()).values, rendering) == stretched
    for alike in (0.05, np.full(160, 0.05)):
        assert not effect.strained(effect.at(zone_width=alike).values, rendering)

"""Pulses that return: drawn with noise they are found, and all that reach into a window are in it."""

from types import SimpleNamespace

import numpy as np
import pytest

from physics.clock import Clock
from physics.pulse import two_piece_pulse
from physics.returning import returning_track, shares_of_all
from physics.tracks import straight_tracks

WIDTH, BINS, FRAMES, LASTED = 1e-10, 60, 64, 4.0
PULSE = two_piece_pulse(1e-10, 2e-10, 2e-11)
CLOCK = Clock(WIDTH, BINS, np.zeros(3), PULSE)


def drawn(first, slope, period, counts, seed=1):
    """Excess of a pulse on a level of 20: arrival at time 0, bins later each second, bins between pulses."""
    time_s = np.linspace(0, LASTED, FRAMES)
    shares = np.zeros((FRAMES, BINS))
    for turn in range(-20, 21):
        shares += PULSE.in_bins((first + slope * time_s + turn * period) * WIDTH, BINS, WIDTH)
    there = 20 + np.array(counts, float)[:, None] * shares[:, None]
    seen = np.random.default_rng(seed).poisson(there)
    return seen - 20.0, np.full(seen.shape, 20.0), SimpleNamespace(clock=CLOCK, light=SimpleNamespace(time_s=time_s))


@pytest.mark.parametrize(
    ("first", "slope", "period"), [(10.0, 45.0, 60.0), (30.0, -70.0, 75.0), (5.0, 50.0, 100.0), (25.0, 13.0, 60.0)]
)
def test_a_pulse_that_returns_is_found(first, slope, period):
    seen = drawn(first, slope, period, [30, 0, 40])
    found = returning_track(*seen)
    assert abs(found.drift / WIDTH - slope) < 2.5
    assert abs(found.period_s / WIDTH - period) < 3.0
    middle = found.arrival_s / WIDTH + found.drift / WIDTH * LASTED / 2 - (first + slope * LASTED / 2)
    assert abs((middle + period / 2) % period - period / 2) < 4.0
    assert found.evidence > 1.3 * max(track.evidence for track in straight_tracks(*seen))


def test_a_quick_one_is_found_in_half_of_the_frames():
    excess, expected, rendering = drawn(10.0, -97.0, 60.0, [30, 20, 40])
    half = np.arange(FRAMES) % 4 < 2
    some = SimpleNamespace(clock=CLOCK, light=SimpleNamespace(time_s=rendering.light.time_s[half]))
    found = returning_track(excess[half], expected[half], some)
    assert abs(found.drift / WIDTH + 97) < 2.5
    assert abs(found.period_s / WIDTH - 60) < 3.0


def test_one_frame_has_none():
    excess, expected, rendering = drawn(10.0, 45.0, 60.0, [30, 30, 30])
    few = SimpleNamespace(clock=CLOCK, light=SimpleNamespace(time_s=rendering.light.time_s[:1]))
    assert returning_track(excess[:1], expected[:1], few) is None


@pytest.mark.parametrize("period", [7e-10, 3e-9, 1e-3])
def test_all_that_reach_into_the_window_are_in_it(period):
    arrival = np.array([-2.3e-9, 0.0, 4.1e-9])
    turns = np.arange(-200, 201) if period < 1e-6 else np.arange(-1, 2)
    each = PULSE.in_bins(arrival[:, None] + turns * period, BINS, WIDTH)
    np.testing.assert_allclose(shares_of_all(PULSE, arrival, period, BINS, WIDTH), each.sum(axis=1), atol=1e-12)

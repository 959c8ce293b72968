"""Tracks: lines that are drawn, with noise, are found where they were drawn."""

from types import SimpleNamespace

import numpy as np
import pytest

from physics.clock import Clock
from physics.pulse import two_piece_pulse
from physics.tracks import straight_tracks

WIDTH = 1e-10
BINS = 60


def drawn(lines, frames=40, lasted=2.0, begins=0.3, seed=1):
    """Excess of pulses (arrival in bins at time 0, bins later each second, counts by zone) on a level of 20."""
    clock = Clock(WIDTH, BINS, np.zeros(3), two_piece_pulse(1e-10, 2e-10, 2e-11))
    time_s = begins + np.linspace(0, lasted, frames)
    there = np.full((frames, 3, BINS), 20.0)
    for first, slope, counts in lines:
        shares = clock.pulse.in_bins((first + slope * time_s) * WIDTH, BINS, WIDTH)
        there += np.array(counts, float)[:, None] * shares[:, None]
    counts = np.random.default_rng(seed).poisson(there)
    light = SimpleNamespace(time_s=time_s)
    return counts - 20.0, np.full(counts.shape, 20.0), SimpleNamespace(clock=clock, light=light)


@pytest.mark.parametrize("counts", [[30, 30, 30], [0, 60, 0]])
@pytest.mark.parametrize(("first", "slope"), [(25.0, 0.0), (10.0, 14.0), (50.5, -18.0), (-20.0, 28.0)])
def test_a_line_is_found_in_all_zones_or_one(first, slope, counts):
    best = straight_tracks(*drawn([(first, slope, counts)]))[0]
    middle = first + slope * 1.3
    assert abs((best.arrival_s + best.drift * 1.3) / WIDTH - middle) < 1.5
    assert abs(best.drift / WIDTH - slope) < 1.5


def test_two_lines_are_both_found_and_no_line_twice():
    tracks = straight_tracks(*drawn([(12.0, 0.0, [60, 0, 0]), (45.0, -5.0, [0, 0, 60])]), most=8)
    middles = np.array([(t.arrival_s + t.drift * 1.3) / WIDTH for t in tracks])
    assert np.abs(middles - 12).min() < 1.5
    assert np.abs(middles - 38.5).min() < 1.5
    ends = [[(t.arrival_s + t.drift * end) / WIDTH for end in (0.3, 2.3)] for t in tracks]
    assert all(np.abs(np.subtract(a, b)).max() > 2 for i, a in enumerate(ends) for b in ends[:i])


def test_none_is_faster_than_asked_for():
    excess = drawn([(10.0, 14.0, [40, 40, 40])])
    assert all(abs(t.drift) <= 3.5 * WIDTH for t in straight_tracks(*excess, fastest=3 * WIDTH))
    assert all(t.drift == 0 for t in straight_tracks(*excess, fastest=0))


def test_many_frames_are_searched_in_parts():
    best = straight_tracks(*drawn([(10.0, 14.0, [5, 5, 5])], frames=1000))[0]
    assert abs(best.drift / WIDTH - 14) < 1.5


def test_noise_has_the_evidence_of_noise():
    """Half of the zones' squares of normal numbers at any one place: far from the hundreds of a pulse."""
    best = straight_tracks(*drawn([]))[0]
    assert best.evidence < 40
    assert straight_tracks(*drawn([(25.0, 0.0, [30, 30, 30])]))[0].evidence > 200

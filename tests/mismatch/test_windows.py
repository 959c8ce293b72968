"""The least likely window, against sums cell by cell and against noise."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import poisson

from mismatch.windows import worst_window

SHAPE = (24, 4, 48)


def seen(counts, dead=None):
    return SimpleNamespace(counts=np.asarray(counts, float), dead=dead)


def test_counts_as_expected_are_no_misfit():
    mean = np.full(SHAPE, 20.0)
    assert worst_window(seen(mean), mean).p_value == 1


@pytest.mark.parametrize("mean", [0.1, 2.0, 50.0])
def test_noise_is_seldom_a_misfit(mean):
    rng = np.random.default_rng(1)
    found = [worst_window(seen(rng.poisson(mean, SHAPE)), np.full(SHAPE, mean)).p_value for _ in range(60)]
    assert np.mean(np.array(found) < 0.05) <= 0.1
    assert min(found) > 1e-4


@pytest.mark.parametrize(("zones", "frames", "bins"), [((2,), (8, 11), (20, 27)), ((0, 1, 2, 3), (4, 4), (12, 15))])
def test_what_flies_by_is_found_where_it_was(zones, frames, bins):
    mean = np.full(SHAPE, 2.0)
    there = np.ix_(np.arange(frames[0], frames[1] + 1), zones, np.arange(bins[0], bins[1] + 1))
    more = mean.copy()
    more[there] += 2.5
    found = worst_window(seen(np.random.default_rng(2).poisson(more)), mean)
    assert found.p_value < 1e-5
    assert found.zones == zones
    assert abs(found.frames[0] - frames[0]) <= 1
    assert abs(found.bins[0] - bins[0]) <= 2


def test_where_nothing_is_expected_nothing_and_a_stray_count_are_no_misfit():
    mean = np.full((128, 9, 128), 1e-12)
    counts = np.zeros(mean.shape)
    assert worst_window(seen(counts), mean).p_value == 1
    counts[5, 3, 7] = 1
    assert worst_window(seen(counts), mean).p_value == 1
    counts[5, 3, 7] = 9
    assert worst_window(seen(counts), mean).p_value < 1e-6


def test_a_dead_zone_is_not_looked_at():
    mean = np.full(SHAPE, 5.0)
    counts = np.random.default_rng(3).poisson(mean)
    counts[:, 1] = 0
    dead = np.array([False, True, False, False])
    assert worst_window(seen(counts, dead), mean).p_value > 1e-3
    assert worst_window(seen(counts), mean).zones == (1,)


@given(st.integers(0, 5), st.integers(0, 2), st.integers(0, 6), st.integers(30, 60))
def test_a_single_cell_has_the_chance_of_its_tail_times_the_number_of_windows(frame, zone, bin_, held):
    mean = np.full((6, 3, 7), 2.0)
    counts = mean.copy()
    counts[frame, zone, bin_] = held
    found = worst_window(seen(counts), mean)
    # Windows of 1, 2, 4 and 6 frames, of 1, 2, 4 and 7 bins, each half its length from the next; three zones and all.
    tried = (6 + 5 + 2 + 1) * (7 + 6 + 2 + 1) * 4
    assert found.p_value == pytest.approx(tried * poisson.sf(held - 1, 2.0), rel=1e-6)
    assert (found.zones, found.frames, found.bins) == ((zone,), (frame, frame), (bin_, bin_))

"""The centroid of what is about the highest bin, against bins picked and weighted one by one."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from physics.about_highest import centroid


@given(about=st.integers(0, 9), seed=st.integers(0, 99))
def test_bins_beside_the_highest_are_weighted_by_what_they_hold(about, seed):
    counts = np.random.default_rng(seed).uniform(0, 9, (2, 3, 30))
    found = centroid(counts, about)
    for frame, zone in np.ndindex(2, 3):
        of = counts[frame, zone]
        top = int(np.argmax(of))
        bins = np.arange(max(top - about, 0), min(top + about, 29) + 1)
        assert found[frame, zone, 0] == pytest.approx(np.average(bins + 0.5, weights=of[bins]))


def test_bins_in_which_it_ends_count_in_part():
    counts = np.array([0.0, 4, 8, 2, 6])
    assert centroid(counts, 0.5)[0] == pytest.approx((1.5 * 2 + 2.5 * 8 + 3.5 * 1) / 11)


def test_where_there_is_nothing_it_is_nowhere_in_particular():
    assert centroid(np.zeros(5), 2.0)[0] == 0

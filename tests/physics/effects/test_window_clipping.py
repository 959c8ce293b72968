"""A window against slices, and against finer bins that it does not divide."""

from types import SimpleNamespace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from physics.effects.window_clipping import effect


def seen(counts, **values):
    return effect.expected(effect.at(**values).values, SimpleNamespace(expected=np.asarray(counts, float)))


@given(early=st.integers(0, 45), late=st.integers(0, 45))
def test_whole_bins_are_a_slice(early, late):
    counts = np.random.default_rng(1).uniform(1, 9, (2, 3, 40))
    wanted = np.zeros_like(counts)
    wanted[..., early : max(40 - late, early)] = counts[..., early : max(40 - late, early)]
    np.testing.assert_array_equal(seen(counts, early=early, late=late), wanted)


@given(early=st.integers(0, 200), late=st.integers(0, 200))
def test_a_divided_bin_is_the_sum_of_finer_ones(early, late):
    fine = np.repeat(np.random.default_rng(2).uniform(1, 9, (1, 2, 20)), 8, axis=-1)
    kept = np.arange(160)
    kept = fine * ((kept >= early) & (kept < 160 - late))
    found = seen(fine.reshape(1, 2, 20, 8).sum(axis=-1), early=early / 8, late=late / 8)
    np.testing.assert_allclose(found, kept.reshape(1, 2, 20, 8).sum(axis=-1))


def test_a_window_of_no_width_holds_nothing():
    np.testing.assert_array_equal(seen(np.ones((2, 2, 6)), early=4, late=3), np.zeros((2, 2, 6)))

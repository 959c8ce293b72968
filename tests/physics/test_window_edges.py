"""Edges of a window, against windows that were laid there and against every pair of edges tried one by one."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from physics.window_edges import emptied, share_lost, summed_window


@given(edge=st.integers(1, 29), lost=st.floats(0.31, 1.0))
def test_the_edge_and_the_share_of_what_lacks_are_told(edge, lost):
    there = np.random.default_rng(edge).uniform(50, 90, 30)
    found = share_lost(np.where(np.arange(30) < edge, lost * there, 0), there, 0.3)
    assert found[0] == edge
    assert found[1] == pytest.approx(lost**2 * there[:edge].sum())
    assert found[2] == pytest.approx(lost)


def test_a_share_is_never_less_than_asked_for_nor_more_than_all():
    there = np.full(5, 10.0)
    assert share_lost(0.1 * there, there, 0.3)[2] == 0.3
    assert share_lost(1.5 * there, there, 0.3)[2] == 1


def test_each_zone_is_empty_up_to_its_own_edge_where_that_shows():
    there = np.full((3, 12), 20.0)
    lacking = np.where(np.arange(12) < np.array([[4], [9], [0]]), there, 0)
    assert emptied(lacking, there).tolist() == [4, 9, 1]
    assert emptied(0.01 * lacking, 0.01 * there).tolist() == [1, 1, 1]


@pytest.mark.parametrize("seed", range(4))
def test_no_other_pair_of_edges_says_better_how_bright_pulses_are(seed):
    rng = np.random.default_rng(seed)
    level = np.array([3.0, 1.0, 7.0])[:, None]
    signal = rng.gamma(0.3, 400, (8, 3, 14))
    first, last = 3 + seed, 9 + seed
    part = signal[..., first:last].sum(axis=-1, keepdims=True) / signal.sum(axis=-1, keepdims=True)
    expected = signal + level
    counts = rng.poisson(level + 1.3 * signal * part)

    def chi(a, b):
        inside, seen = signal[..., a:b].sum(axis=-1).ravel(), (counts - level).sum(axis=-1).ravel()
        sigma = np.sqrt(expected.sum(axis=-1).ravel())
        gain, *_ = np.linalg.lstsq((inside / sigma)[:, None], seen / sigma, rcond=None)
        return (((seen - gain * inside) / sigma) ** 2).sum()

    early, late = summed_window(counts - expected, expected, level)
    every = {(a, b): chi(a, b) for a in range(14) for b in range(a + 1, 15)}
    assert (early, 14 - late) == min(every, key=every.get)
    assert every[early, 14 - late] <= every[first, last]


def test_pulses_that_are_as_bright_as_thought_or_alike_dimmer_tell_no_window():
    expected = 5 + np.random.default_rng(3).gamma(0.5, 400, (20, 3, 14))
    assert summed_window(0 * expected, expected, 5.0) is None
    assert summed_window(-0.2 * (expected - 5), expected, 5.0) is None
    assert summed_window(np.zeros((2, 2, 5)), np.full((2, 2, 5), 5.0), 5.0) is None

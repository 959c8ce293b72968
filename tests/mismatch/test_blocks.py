"""Frames that choose and frames that decide."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mismatch.blocks import halves
from recordings.refusal import Refusal


@given(st.integers(2, 2000))
def test_halves_are_disjoint_and_cover_all_frames(frames):
    chosen, held = halves(frames)
    np.testing.assert_array_equal(np.sort(np.concatenate([chosen, held])), np.arange(frames))
    assert len(chosen)
    assert len(held)


@given(st.integers(120, 2000))
def test_they_are_blocks_so_that_few_frames_have_a_neighbour_on_the_other_side(frames):
    chosen, held = halves(frames)
    side = np.zeros(frames, bool)
    side[held] = True
    assert np.count_nonzero(np.diff(side.astype(int))) <= 14
    assert abs(len(chosen) - len(held)) <= frames // 12 + 1


@pytest.mark.parametrize("frames", [0, 1])
def test_fewer_than_two_frames_are_refused(frames):
    with pytest.raises(Refusal, match=f"has {frames} frame, expected 2 or more"):
        halves(frames)

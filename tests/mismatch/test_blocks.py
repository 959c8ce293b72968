"""Frames that choose and frames that decide."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mismatch.blocks import finer, halves
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
    assert np.count_nonzero(np.diff(side.astype(int))) <= 30
    assert abs(len(chosen) - len(held)) <= frames // 8


@given(st.integers(96, 200), st.integers(2, 40))
def test_a_scene_that_comes_back_again_and_again_shows_both_sides_all_of_its_places(frames, period):
    """Stops of equal length, or to and fro: each of its phases that lasts long enough is on both sides."""
    chosen, held = halves(frames)
    phase = np.arange(frames) % period * 2 // period
    for side in (chosen, held):
        share = np.bincount(phase[side], minlength=2) / np.bincount(phase, minlength=2)
        assert (share > 0.2).all()


@pytest.mark.parametrize("frames", [0, 1])
def test_fewer_than_two_frames_are_refused(frames):
    with pytest.raises(Refusal, match=f"has {frames} frame, expected 2 or more"):
        halves(frames)


@given(st.integers(2, 300))
def test_as_many_blocks_as_frames_are_single_frames(frames):
    """By the sequence of Thue and Morse: digits of the frame's number."""
    _, held = halves(frames, frames)
    side = np.isin(np.arange(frames), held)
    np.testing.assert_array_equal(side, [bin(i).count("1") % 2 == 1 for i in range(frames)])


@given(st.integers(2, 300))
def test_finer_halves_hold_each_frame_once_and_differ(frames):
    """From three frames on: of two there is one way."""
    every = [halves(frames), *finer(frames)]
    for chosen, held in every:
        np.testing.assert_array_equal(np.sort(np.concatenate([chosen, held])), np.arange(frames))
    assert len({chosen.tobytes() for chosen, _ in every}) == len(every) or frames < 3
    # The last deals any two neighbours to two sides.
    assert (np.diff(np.isin(np.arange(frames), every[-1][1])) != 0).all()

"""The interval of frames, from some of them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from physics.pace import frame_interval_s


@given(st.integers(8, 200), st.floats(1e-3, 1e3), st.integers(0, 2**32 - 1))
def test_half_of_evenly_taken_frames_tell_it(frames, interval_s, seed):
    """Of each two frames one, whichever: now and then two are neighbours."""
    held = np.random.default_rng(seed).integers(0, 2, frames)
    held[:2] = 1, 0  # Frames 1 and 2 are taken.
    taken = 2 * np.arange(frames) + held
    closest = np.sort(np.diff(taken))[len(taken) // 10 + 1]
    assert interval_s * (1 - 1e-9) <= frame_interval_s(interval_s * taken) <= interval_s * closest * (1 + 1e-9)


def test_a_frame_alone_has_none():
    assert frame_interval_s(np.array([3.0])) == 0.0
    assert frame_interval_s(np.zeros(0)) == 0.0


def test_bursts_do_not_make_it_endlessly_short():
    time_s = np.concatenate([1e-9 * np.arange(10), 100 + 1e-9 * np.arange(10)])
    assert frame_interval_s(time_s) == pytest.approx(100 / 4096)

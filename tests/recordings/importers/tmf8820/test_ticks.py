"""Times from the sensor's counter."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from recordings.importers.tmf8820.ticks import tick_times_s


@given(
    start=st.integers(0, (1 << 31) - 1),
    steps=st.lists(st.integers(1, (1 << 31) - 1), max_size=20),
)
def test_times_rise_by_the_steps_over_any_number_of_wraps(start, steps):
    ticks = [2 * start + 1]
    for step in steps:
        ticks.append((ticks[-1] + 2 * step) % (1 << 32))
    times = tick_times_s(ticks)
    np.testing.assert_allclose(np.diff(times), [2 * step * 200e-9 for step in steps], atol=1e-10)
    assert times[0] == 0


@pytest.mark.parametrize(
    "ticks",
    [None, [1, 2], [1, 1], [1, None], [1, "3"], [1.0, 3.0], [[1], [3]], [1, [3]], [-1, 3], [1, (1 << 32) + 1]],
)
def test_a_counter_that_cannot_be_trusted_gives_no_times(ticks):
    assert tick_times_s(ticks) is None

"""Windows against a list of all views: what a batch is given holds all that it needs, and little more."""

import itertools

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from physics.scene.view import View
from physics.scene.windows import windows

SECONDS = st.floats(0, 1.5)


@given(
    gaps=st.lists(st.floats(0, 0.5), min_size=1, max_size=25),
    size=st.integers(1, 9),
    reaches=st.lists(st.tuples(SECONDS, SECONDS), max_size=2),
)
def test_each_batch_has_all_that_is_within_reach(gaps, size, reaches):
    times = 100 + np.cumsum(gaps)
    views = [View(float(time), np.zeros((1, 1))) for time in times]
    seen = []
    for around, batch in windows(iter(views), size, times[0], reaches):
        first = views.index(around[0])
        assert around == views[first : first + len(around)]
        seen += around[batch]
        earliest, latest = views.index(around[batch][0]), views.index(around[batch][-1])
        for before, after in reaches:
            start, stop = times[earliest] - times[0] - before, times[latest] - times[0] + after
            while earliest > 0 and times[earliest] - times[0] > start:
                earliest -= 1
            while latest < len(views) - 1 and times[latest] - times[0] < stop:
                latest += 1
        assert (first, first + len(around) - 1) == (earliest, latest)
    assert seen == views


def test_no_more_views_are_read_than_are_needed():
    read = itertools.count()
    views = (View(0.1 * next(read), np.zeros((1, 1))) for _ in range(1000))
    around, batch = next(windows(views, 4, 0.0, [(0.0, 0.25)]))
    assert (len(around), batch) == (7, slice(0, 4))
    assert next(read) == 7

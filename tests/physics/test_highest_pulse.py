"""The highest pulse of a histogram of two, and where its middle is."""

from dataclasses import replace

import numpy as np
import pytest

from physics.arrivals import arrivals
from physics.highest_pulse import highest_turns
from physics.light import Return

C = 299_792_458.0


def seen(small, near_m, far_m, part):
    """Arrivals from two surfaces, the far one sending `part` of what both do."""
    shape = small.light.range_m.shape
    ways = (np.full(shape, near_m, np.float32), 1 - part), (np.full(shape, far_m, np.float32), part)
    returns = tuple(Return(ranges, np.full(shape, light, np.float32)) for ranges, light in ways)
    return arrivals(replace(small.light, returns=returns), small.footprints, small.clock)


@pytest.mark.parametrize(("part", "highest_m"), [(0.3, 0.4), (0.7, 1.1)])
def test_of_two_pulses_the_higher_tells(small, part, highest_m):
    found = highest_turns(seen(small, 0.4, 1.1, part), small.clock)[..., 0]
    due = (np.asarray(small.clock.time_zero_s) + 2 * highest_m / C) / small.clock.bin_width_s
    np.testing.assert_allclose(found, np.broadcast_to(due, found.shape), atol=1e-3)


def test_of_two_that_are_one_the_middle_tells(small):
    found = highest_turns(seen(small, 0.600, 0.606, 0.25), small.clock)[..., 0]
    due = (np.asarray(small.clock.time_zero_s) + 2 * 0.6015 / C) / small.clock.bin_width_s
    np.testing.assert_allclose(found, np.broadcast_to(due, found.shape), atol=1e-3)

"""The highest pulse of a histogram of two, and where its middle is."""

from dataclasses import replace

import numpy as np
import pytest

from physics.arrivals import arrivals
from physics.highest_pulse import highest_turns
from physics.light import Return
from physics.pulse import ImpulseResponse

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


def test_a_narrow_window_is_about_the_peak_of_a_lopsided_pulse(small):
    """Of a long-tailed pulse the peak is well before the mean; light at one place is found there none the less."""
    steps = np.arange(60) * small.clock.bin_width_s / 10
    pulse = ImpulseResponse(steps, np.exp(-steps / (8 * steps[1])) / np.exp(-steps / (8 * steps[1])).sum())
    clock = replace(small.clock, pulse=pulse)
    shape = small.light.range_m.shape
    light = replace(small.light, returns=(Return(np.full(shape, 0.8, np.float32), np.ones(shape, np.float32)),))
    found = highest_turns(arrivals(light, small.footprints, clock), clock, 0.1)[..., 0]
    due = (np.asarray(clock.time_zero_s) + 2 * 0.8 / C) / clock.bin_width_s
    np.testing.assert_allclose(found, np.broadcast_to(due, found.shape), atol=0.02)


def test_less_of_the_pulse_tells_in_a_narrower_window(small):
    """A weak surface beside a strong one draws the middle of all of the pulse, and less that of its peak."""
    near, far = (
        highest_turns(seen(small, 0.60, 0.64, 0.2), small.clock, within)[..., 0].mean() for within in (0.1, 1.0)
    )
    wanted = (np.mean(small.clock.time_zero_s) + 2 * 0.60 / C) / small.clock.bin_width_s
    assert abs(near - wanted) < 0.5 * abs(far - wanted)

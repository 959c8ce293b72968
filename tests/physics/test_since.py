"""Effects that set in with some frame: each frame by itself is with them or without."""

import numpy as np
import pytest

from physics.effects import find_effect
from physics.nominal import ForwardModel

GAIN, WEAK = find_effect("zone_gain"), find_effect("ambient_pedestal")


@pytest.mark.parametrize("since", [0.0, 0.05, 0.1, 0.15, 7.0])
def test_frames_are_with_it_or_without(small, since):
    model = ForwardModel(small.light, small.footprints, small.clock)
    found = model.expected(1e3, [GAIN.at(factor=0.5, since=since)])
    always, never = model.expected(1e3, [GAIN.at(factor=0.5)]), model.expected(1e3)
    for frame, time_s in enumerate((0.0, 0.1, 0.2)):
        np.testing.assert_array_equal(found[frame], (always if time_s >= since else never)[frame])


def test_some_frames_of_a_session_know_when_it_began(small):
    late = ForwardModel(small.light.of(np.array([1, 2])), small.footprints, small.clock)
    found = late.expected(1e3, [GAIN.at(factor=0.5, since=0.05)])
    np.testing.assert_array_equal(found, late.expected(1e3, [GAIN.at(factor=0.5)]))


def test_two_may_set_in_one_after_the_other(small):
    model = ForwardModel(small.light, small.footprints, small.clock)
    weak, bright = GAIN.at(factor=0.5, since=0.2), WEAK.at(level=3.0, since=0.1)
    found = model.expected(1e3, [weak, bright])
    nominal = model.expected(1e3)
    np.testing.assert_array_equal(found[0], nominal[0])
    np.testing.assert_allclose(found[1], nominal[1] + 3, rtol=1e-9)
    np.testing.assert_allclose(found[2], 0.5 * nominal[2] + 3, rtol=1e-9)


def test_no_frames_are_no_counts(small):
    model = ForwardModel(small.light.of(np.zeros(0, int)), small.footprints, small.clock)
    assert model.expected(1e3, [GAIN.at(factor=0.5, since=0.1)]).shape == (0, 4, 40)

"""Drift against sensors whose time zero is that of each frame."""

from dataclasses import replace

import numpy as np
import pytest

from physics.effects.time_zero_drift import effect
from physics.nominal import ForwardModel
from physics.rendering import Rendering


@pytest.mark.parametrize("rate", [4e-10, np.array([4e-10, 0, -2e-10, 1e-10])])
@pytest.mark.parametrize(("curve", "zero_at"), [(0, 0), (3e-9, 0), (0, 0.15), (-2e-9, 0.07)])
def test_each_frame_is_that_of_a_sensor_with_its_own_time_zero(small, curve, zero_at, rate):
    model = ForwardModel(small.light, small.footprints, small.clock)
    found = model.expected(1e3, [effect.at(rate=rate, curve=curve, zero_at=zero_at)])
    for i, time in enumerate((0.0, 0.1, 0.2)):
        late = rate * (time - zero_at) + curve * (time - zero_at) * (time + zero_at)
        clock = replace(small.clock, time_zero_s=small.clock.time_zero_s + late)
        other = ForwardModel(small.light, small.footprints, clock).expected(1e3)[i]
        np.testing.assert_allclose(found[i], other, atol=3e-3 * other.max())


def test_counts_are_kept_and_the_first_frame_stays(small):
    model = ForwardModel(small.light, small.footprints, small.clock)
    nominal, found = model.expected(1e3), model.expected(1e3, [effect.at(rate=-3e-10)])
    np.testing.assert_array_equal(found[0], nominal[0])
    assert np.abs(found[2] - nominal[2]).max() > 1e-2 * nominal.max()
    last = nominal[..., -8:].sum()
    np.testing.assert_allclose(found.sum(), nominal.sum(), atol=last + 1e-6 * nominal.sum())


def test_time_zero_is_right_at_some_time_within_the_session(small):
    model = ForwardModel(small.light, small.footprints, small.clock)  # 0.2 s long
    last, beyond = (model.expected(1e3, [effect.at(rate=4e-10, zero_at=at)]) for at in (0.2, 7.0))
    np.testing.assert_array_equal(last[2], model.expected(1e3)[2])
    np.testing.assert_array_equal(beyond, last)


def test_it_suggests_the_jump(small):
    light = replace(small.light, time_s=np.array([0.0, 0.1, 0.3]))
    model = ForwardModel(light, small.footprints, small.clock, 3.0)
    nominal = model.expected(1e4)
    excess = model.expected(1e4, [effect.at(jump=3e-11, jump_at=0.04)]) - nominal
    rendering = Rendering(light, small.footprints, small.clock, 1e4, background=3.0)
    jump = next(start for start in effect.starts(excess, nominal, rendering) if "jump" in start)
    assert jump["jump_at"] == pytest.approx(0.05)


def test_a_walk_begins_at_the_start_and_in_the_middle_of_the_session(small):
    light = replace(small.light, time_s=np.array([0.0, 0.1, 0.6]))
    nominal = ForwardModel(light, small.footprints, small.clock, 3.0).expected(1e4)
    rendering = Rendering(light, small.footprints, small.clock, 1e4, background=3.0)
    walks = [start for start in effect.starts(0 * nominal, nominal, rendering) if "every" in start]
    assert [walk["every"] for walk in walks] == pytest.approx([0.1, 0.1])
    assert [walk.get("zero_at") for walk in walks] == [None, pytest.approx(0.7 / 3)]

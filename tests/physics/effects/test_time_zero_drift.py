"""Drift against sensors whose time zero is that of each frame."""

from dataclasses import replace

import numpy as np
import pytest

from physics.effects.time_zero_drift import effect
from physics.nominal import ForwardModel
from physics.rendering import Rendering


@pytest.mark.parametrize(("curve", "at_start"), [(0, 0), (3e-9, 0), (0, 6e-11)])
def test_each_frame_is_that_of_a_sensor_with_its_own_time_zero(small, curve, at_start):
    rate = 4e-10
    model = ForwardModel(small.light, small.footprints, small.clock)
    found = model.expected(1e3, [effect.at(rate=rate, curve=curve, at_start=at_start)])
    for i, time in enumerate((0.0, 0.1, 0.2)):
        late = at_start + rate * time + curve * time * time
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


def test_a_delay_that_hardly_changes_is_no_drift(small):
    rendering = Rendering(small.light, small.footprints, small.clock, 1.0)  # 0.2 s long
    assert effect.strained(effect.at(rate=1e-10, at_start=-5e-11).values, rendering)
    assert not effect.strained(effect.at(rate=1e-10, at_start=-3e-11).values, rendering)
    assert not effect.strained(effect.at(warmup=-1e-10, tau=0.01, at_start=1e-10).values, rendering)

"""Stated intervals hold the truth as often as they say."""

import numpy as np
import pytest

from mismatch.prove.coverage import coverage, forms_like
from physics.effects import find_effect

SHAPE = (24, 9, 128)
# Effects that act on the scene, in the optics, in time, in the detector and in the estimator.
QUICK = (
    "ambient_pedestal",
    "bin_phase",
    "bin_width_error",
    "counter_saturation",
    "cover_glass_crosstalk",
    "footprint_shift",
    "impulse_tail",
    "second_surface",
    "stray_light",
    "time_zero_offset",
)


def test_the_plainest_form_that_holds_a_setting():
    drift = find_effect("ambient_pedestal")
    names = {form.name for form in forms_like(drift.at(level=2.0, growth=0.0), SHAPE)}
    assert names == {"ambient_pedestal(level)"}
    names = {form.name for form in forms_like(drift.at(level=2.0, growth=1.0), SHAPE)}
    assert names == {"ambient_pedestal(level, growth)"}
    names = {form.name for form in forms_like(drift.at(level=np.arange(1.0, 10)), SHAPE)}
    assert names == {"ambient_pedestal(level[])"}


def test_pulls_are_those_of_every_recording():
    effect = find_effect("ambient_pedestal")
    found, again = (coverage(effect, 2, seed=5) for _ in range(2))
    assert found.recordings == 2
    assert found.astray == 0
    assert found.pulls.keys() <= {"level", "growth", "more"}
    assert sum(len(pulls) for pulls in found.pulls.values()) >= 2
    for name, pulls in found.pulls.items():
        np.testing.assert_array_equal(pulls, again.pulls[name])
    assert found.within(1e9) == 1


@pytest.mark.slow
def test_two_of_three_intervals_of_one_sigma_hold_the_truth():
    found = [coverage(find_effect(name), 20, seed=21) for name in QUICK]
    assert sum(one.astray for one in found) <= 10
    # Effects count alike, however many parameters they have.
    assert np.mean([one.within(1.0) for one in found]) == pytest.approx(0.683, abs=0.06)
    assert np.mean([one.within(1.96) for one in found]) == pytest.approx(0.95, abs=0.03)

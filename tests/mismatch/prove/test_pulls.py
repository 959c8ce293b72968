import numpy as np
import pytest

from mismatch.prove.pulls import pulls
from mismatch.verdict import Estimate
from physics.effects import find_effect


def test_a_parameter_that_both_sides_name():
    found = [Estimate("share", 0.12, 0.01, "1"), Estimate("tau", 3e-10, 0.0, "s")]
    there = pulls(find_effect("impulse_tail"), {"share": 0.1, "tau": 3e-10}, found)
    assert there.keys() == {"share"}  # One that has no error was not fitted.
    assert there["share"] == pytest.approx([2.0])


def test_one_value_is_not_compared_with_many():
    found = [Estimate("delay[0]", 1.0, 0.5, "s"), Estimate("delay[2]", 3.0, 0.5, "s")]
    effect = find_effect("time_zero_offset")
    assert pulls(effect, {"delay": 1.0}, found) == {}
    np.testing.assert_allclose(pulls(effect, {"delay": [2.0, 9.0, 3.0]}, found)["delay"], [-2.0, 0.0])


def test_of_factors_only_ratios_count():
    found = [Estimate("factor[0]", 2.0, 0.1, "1"), Estimate("factor[1]", 4.2, 0.1, "1")]
    (there,) = pulls(find_effect("zone_gain"), {"factor": [1.0, 2.0]}, found).values()
    truth = np.array([1.0, 2.0]) * 3.1 / 1.5
    np.testing.assert_allclose(there, (np.array([2.0, 4.2]) - truth) / 0.1)


def test_another_form_of_the_effect_has_no_errors_to_be_judged():
    tail, lingers = find_effect("impulse_tail"), {"lingering": 0.1, "duration": 1e-9}
    truth = {**tail.vanished().values, **lingers}
    estimates = [Estimate("share", 0.12, 0.01, "1"), Estimate("tau", 3e-10, 1e-11, "s")]
    assert pulls(tail, truth, estimates) == {}
    heavy = tail.at(share=0.1, tau=2e-10, heavy=0.6).values
    assert pulls(tail, heavy, estimates) == {}  # How it falls is not in the answer.
    assert pulls(tail, tail.at(share=0.1, tau=2e-10).values, estimates).keys() == {"share", "tau"}
    more = [*estimates, Estimate("heavy", 0.2, 0.1, "1")]  # What nobody concealed may be estimated, if it does no harm.
    assert pulls(tail, tail.at(share=0.1, tau=2e-10).values, more)["heavy"] == pytest.approx([2.0])

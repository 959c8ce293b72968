"""A parameter and its coordinate: there and back, within bounds."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mismatch.coordinate import bounds, error_of, logarithmic, slope_of, to_coordinate, to_value
from physics.effects import all_effects, find_effect


@given(st.sampled_from([p for e in all_effects().values() for p in e.parameters]), st.floats(-1e9, 1e9))
def test_no_coordinate_leads_out_of_bounds(parameter, x):
    low, high = bounds(parameter)
    assert low < high
    value = to_value(parameter, float(np.clip(x, low, high)))
    assert parameter.low <= value <= parameter.high


def test_times_over_decades_are_fitted_by_their_logarithm_and_strengths_are_not():
    effect = find_effect("impulse_tail")
    tau, share = effect.parameter("tau"), effect.parameter("share")
    assert logarithmic(tau)
    assert not logarithmic(share)
    assert to_coordinate(tau, tau.start * np.e) == pytest.approx(1)
    assert to_coordinate(share, share.vanishes_at) == 0


def test_what_sets_in_with_its_square_is_fitted_by_its_square():
    jitter = find_effect("impulse_width").parameter("jitter")
    assert to_coordinate(jitter, 2 * jitter.start) == pytest.approx(4)
    assert to_value(jitter, 9.0) == pytest.approx(3 * jitter.start)
    assert to_value(jitter, 0.0) == 0


@given(st.sampled_from([p for e in all_effects().values() for p in e.parameters]), st.floats(0.1, 3))
def test_slopes_are_those_of_the_value(parameter, x):
    low, high = bounds(parameter)
    x = float(np.clip(x, low + 0.1 * (high - low) if high - low < 1 else low, high - 1e-3 * (high - low)))
    if not low + 1e-5 < x < high - 1e-5:
        return
    apart = to_value(parameter, x + 1e-6) - to_value(parameter, x - 1e-6)
    assert slope_of(parameter, x) == pytest.approx(apart / 2e-6, rel=1e-3)


@pytest.mark.parametrize("sigma", [0.01, 0.5, 3.0])
def test_an_error_is_as_far_as_the_value_may_be_on_either_side(sigma):
    tau = find_effect("afterpulsing").parameter("tau")
    x = to_coordinate(tau, 4e-9)
    assert error_of(tau, x, sigma) == pytest.approx(4e-9 * np.expm1(sigma), rel=1e-9)
    # A factor that goes beyond the bounds ends there.
    assert error_of(tau, x, 30.0) == pytest.approx(tau.high - 4e-9)
    level = find_effect("ambient_pedestal").parameter("level")
    assert error_of(level, to_coordinate(level, 3.0), sigma) == pytest.approx(sigma * level.size)

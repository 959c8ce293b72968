"""Coordinates of a fit and settings of effects: there and back, within bounds."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mismatch.form import all_forms, bounds, error_of, forms_of, logarithmic, slope_of, to_coordinate, to_value
from physics.effects import all_effects, find_effect

STABLE = ("impulse_tail", "time_zero_offset", "ambient_pedestal", "stray_light", "pile_up", "zone_gain")
SIZES = {"zone": 3, "bin": 5, "edge": 4}
FORMS = [form for name in STABLE for form in forms_of(find_effect(name), SIZES)]


@settings(max_examples=200)
@given(st.sampled_from(FORMS), st.data())
def test_coordinates_become_a_setting_and_come_back(form, data):
    x = np.array([data.draw(st.floats(*bounds(parameter))) for parameter, _ in form.coordinates])
    setting = form.setting(x)
    np.testing.assert_allclose(form.coordinates_of(setting), x, rtol=1e-9, atol=1e-9)


@given(st.sampled_from([p for e in all_effects().values() for p in e.parameters]), st.floats(-1e9, 1e9))
def test_no_coordinate_leads_out_of_bounds(parameter, x):
    low, high = bounds(parameter)
    assert low < high
    value = to_value(parameter, float(np.clip(x, low, high)))
    assert parameter.low <= value <= parameter.high


@pytest.mark.parametrize("name", STABLE)
def test_the_start_is_where_the_effect_starts(name):
    for form in forms_of(find_effect(name), SIZES):
        begun = form.setting(form.at_start()).values
        for parameter in form.effect.parameters:
            np.testing.assert_allclose(begun[parameter.name], form.start[parameter.name], rtol=1e-12)


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


def test_an_effect_of_zones_is_tried_with_one_value_and_with_one_for_each():
    common, divided = (form for form in forms_of(find_effect("zone_gain"), SIZES) if "factor" in form.free)
    assert len(common.coordinates) == 1
    assert len(divided.coordinates) == 3
    assert divided.setting(np.array([1.0, 2.0, 3.0])).values["factor"] == pytest.approx([1.1, 2.2, 3.3])
    assert common.name == "zone_gain(factor)"
    assert divided.name == "zone_gain(factor[])"


def test_a_form_begins_elsewhere_only_by_parameters_it_has():
    form = FORMS[0]
    assert form.beginning({"tau": 7e-10}).start["tau"] == 7e-10
    assert form.beginning({"factor": 2.0}) is None
    assert form.beginning({"tau": 7e-10, "lingering": 0.1}) is None


def test_zones_that_had_values_of_their_own_begin_amid_them_where_all_have_one():
    forms = {form.free: form for form in forms_of(find_effect("counter_saturation"), SIZES) if not form.own}
    apart, alike = forms["lost",], forms["lost", "ceiling"]
    begun = apart.beginning({"lost": 0.5, "ceiling": np.array([400.0, 500.0, 700.0])})
    found = alike.setting(alike.coordinates_from(begun, begun.setting(np.array([1.0])))).values
    assert found["ceiling"] == pytest.approx(500.0)


def test_effects_that_are_given_are_not_tried():
    ids = {form.effect.id for form in all_forms(SIZES, without=("pile_up",))}
    assert ids == set(all_effects()) - {"pile_up"}


@pytest.mark.parametrize("sigma", [0.01, 0.5, 3.0])
def test_an_error_is_as_far_as_the_value_may_be_on_either_side(sigma):
    tau = find_effect("afterpulsing").parameter("tau")
    x = to_coordinate(tau, 4e-9)
    assert error_of(tau, x, sigma) == pytest.approx(4e-9 * np.expm1(sigma), rel=1e-9)
    # A factor that goes beyond the bounds ends there.
    assert error_of(tau, x, 30.0) == pytest.approx(tau.high - 4e-9)
    level = find_effect("ambient_pedestal").parameter("level")
    assert error_of(level, to_coordinate(level, 3.0), sigma) == pytest.approx(sigma * level.size)

"""Coordinates of a fit and settings of effects: there and back, within bounds."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mismatch.coordinate import bounds
from mismatch.form import all_forms, forms_of
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


@pytest.mark.parametrize("name", STABLE)
def test_the_start_is_where_the_effect_starts(name):
    for form in forms_of(find_effect(name), SIZES):
        begun = form.setting(form.at_start()).values
        for parameter in form.effect.parameters:
            np.testing.assert_allclose(begun[parameter.name], form.start[parameter.name], rtol=1e-12)


def test_an_effect_of_zones_is_tried_with_one_value_and_with_one_for_each():
    common, divided = (form for form in forms_of(find_effect("ambient_pedestal"), SIZES) if form.free == ("level",))
    assert len(common.coordinates) == 1
    assert len(divided.coordinates) == 3
    assert divided.setting(np.array([1.0, 2.0, 3.0])).values["level"] == pytest.approx([10, 20, 30])
    assert common.name == "ambient_pedestal(level)"
    assert divided.name == "ambient_pedestal(level[])"


def test_what_differs_by_zone_in_any_case_has_no_form_that_all_share():
    for effect, free in (("bin_width_error", ("apart",)), ("zone_gain", ("factor",))):
        (apart,) = (form for form in forms_of(find_effect(effect), SIZES) if form.free == free)
        assert apart.own == free


def test_a_form_begins_elsewhere_only_by_parameters_it_has():
    form = FORMS[0]
    assert form.beginning({"tau": 7e-10}).start["tau"] == 7e-10
    assert form.beginning({"factor": 2.0}) is None
    assert form.beginning({"tau": 7e-10, "lingering": 0.1}) is None
    assert form.beginning({"tau": 7.0}) is None


def test_zones_that_had_values_of_their_own_begin_amid_them_where_all_have_one():
    forms = {form.free: form for form in forms_of(find_effect("counter_saturation"), SIZES) if not form.own}
    apart, alike = forms["lost",], forms["lost", "ceiling"]
    begun = apart.beginning({"lost": 0.5, "ceiling": np.array([400.0, 500.0, 700.0])})
    found = alike.setting(alike.coordinates_from(begun, begun.setting(np.array([1.0])))).values
    assert found["ceiling"] == pytest.approx(500.0)


def test_effects_that_are_given_are_not_tried():
    ids = {form.effect.id for form in all_forms(SIZES, without=("pile_up",))}
    assert ids == set(all_effects()) - {"pile_up"}


@pytest.mark.parametrize(("zones", "bins", "tried"), [(3, 5, True), (18, 128, True), (64, 128, False)])
def test_bins_of_every_zone_are_tried_unless_there_are_too_many(zones, bins, tried):
    forms = list(forms_of(find_effect("bin_nonlinearity"), {"zone": zones, "bin": bins}))
    many = [form for form in forms if set(form.own) & {"zone_edge", "zone_width"}]
    assert [len(form.coordinates) for form in many] == [zones * bins] * (2 if tried else 0)
    assert {"edge", "width"} <= {name for form in forms for name in form.own}

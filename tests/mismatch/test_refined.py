"""Richer forms of an effect that was chosen: taken where something is left that they explain, and only there."""

import numpy as np
import pytest

from mismatch.fit import fit, fit_nominal, on_others
from mismatch.form import all_forms, forms_of
from mismatch.leftover import what_is_left
from mismatch.refined import enlarged, enriched, plainer, refined, richer
from physics.effects import find_effect
from recordings.refusal import Refusal

SIZES = {"zone": 4, "bin": 48}
FORMS = all_forms(SIZES)
EVEN, ODD = np.arange(0, 24, 2), np.arange(1, 24, 2)


def common(name):
    return next(form for form in forms_of(find_effect(name), SIZES) if not form.own)


def chosen(simulation, form):
    return fit(simulation, (form,), np.concatenate([fit_nominal(simulation).x, form.at_start()]))


def test_zones_have_their_own_where_they_differ(drawn):
    simulation = drawn(3, "ambient_pedestal", level=[0.0, 2.0, 6.0, 1.0])
    train, test = simulation.of(EVEN), simulation.of(ODD)
    one = chosen(train, common("ambient_pedestal"))
    found = refined(train, test, one, FORMS)
    assert found.forms[0].own == ("level",)
    assert found.deviance < one.deviance - 50
    np.testing.assert_allclose(found.settings[0].values["level"], [0, 2, 6, 1], atol=0.5)


def test_where_nothing_is_left_it_stays_as_it_is(drawn):
    simulation = drawn(4, "ambient_pedestal", level=3.0)
    train, test = simulation.of(EVEN), simulation.of(ODD)
    one = chosen(train, common("ambient_pedestal"))
    assert refined(train, test, one, FORMS) is one


def test_reflectance_that_follows_no_order_is_told_patch_by_patch(drawn):
    """Whatever plainer form it was taken for; as random as it is, frames held out are predicted by it."""
    texture = np.random.default_rng(5).normal(0, 0.3, 128)
    simulation = drawn(3, "reflectance_map", patch=texture)
    train, test = simulation.of(EVEN), simulation.of(ODD)
    one = chosen(train, next(form for form in FORMS if form.free == ("contrast",)))
    found = refined(train, test, one, FORMS)
    assert found.forms[0].own == ("patch",)
    assert found.deviance < one.deviance - 200
    assert on_others(test, found)[1] < on_others(test, one)[1] - 200
    assert not what_is_left(train, found)
    # Numbers are shrunk by what noise has widened them, not beyond what was drawn.
    assert 0.15 < found.pattern.width * found.forms[0].effect.parameter("patch").start < 0.5


def test_what_is_newly_free_begins_where_its_form_does():
    roams = next(f for f in FORMS if f.free == ("roaming", "present") and not f.own)
    longer = next(f for f in FORMS if f.free == ("roaming", "present", "longer") and not f.own)
    setting = roams.effect.at(roaming=7.0, present=0.4)
    found = longer.setting(longer.coordinates_from(roams, setting)).values
    assert [found[n] for n in longer.free] == pytest.approx([7.0, 0.4, longer.start["longer"]])
    assert longer.start["longer"] > 0


@pytest.mark.parametrize("name", ["ambient_pedestal", "range_aliasing", "interference", "time_lag"])
def test_richer_forms_hold_all_that_the_form_has(name):
    form = common(name)
    found = list(richer(form, FORMS))
    for other in found:
        assert other.effect is form.effect
        assert set(other.strengths) >= set(form.strengths)
        assert set(other.free) - set(form.free) or other.own != form.own
        assert set(other.own) >= set(form.own)
        assert (other.free, other.own) != (form.free, form.own)
        # A fit may begin where the other ended.
        assert len(other.coordinates_of(form.setting(form.at_start()))) == len(other.coordinates)
    assert (name != "time_lag") == any(other.own for other in found)
    if name == "range_aliasing":
        assert any(other.own == ("counts", "apparent_range") for other in found)


def test_zones_have_nothing_of_their_own_where_that_takes_too_long():
    """A mount that slips: maps of each zone would be read at another place in each frame."""
    slips = [form for form in FORMS if form.effect.id == "footprint_shift" and "slip_x" in form.free]
    assert slips
    assert not any(form.own for form in slips)
    assert not any(other.own for other in richer(slips[0], FORMS))
    apart = next(form for form in FORMS if form.free == ("x", "y") and form.own)
    assert not any("slip_x" in other.free for other in richer(apart, FORMS))


@pytest.mark.slow
def test_a_form_that_leaves_other_parameters_free_is_tried_in_its_place(drawn):
    """A blur that was taken for longer one way, and is sharper and not brought back to its sum."""
    blur = {f.free: f for f in FORMS if f.effect.id == "footprint_blur"}
    taller, sharper = blur["variance", "taller"], blur["variance", "amount", "kept"]
    assert sharper.free in {other.free for other in richer(taller, FORMS)}
    train = drawn(3, "footprint_blur", variance=-500.0, amount=2.0, kept=0.0)
    begun = next(f for f in FORMS if f.free == taller.free and f.start["variance"] < 0)
    found = enriched(train, chosen(train, begun), FORMS)
    assert found.forms[0].free == sharper.free
    assert found.settings[0].values["taller"] == 0


def test_a_form_of_many_strengths_is_tried_where_another_leaves_something(drawn):
    """A pattern of eight bins that was taken for a wave; patterns are too many numbers to begin a search with."""
    bins = {f.free: f for f in FORMS if f.effect.id == "bin_nonlinearity"}
    wave, pattern = bins["wave_sin", "wave_cos", "period", "moved"], next(f for f in bins.values() if "tap_1" in f.free)
    assert pattern.free in {other.free for other in richer(wave, FORMS)}
    assert wave.free not in {other.free for other in richer(pattern, FORMS)}
    taps = dict(zip(pattern.strengths, [0.2, -0.1, -0.15, 0.1, 0.05, -0.2, 0.15], strict=True))
    simulation = drawn(3, "bin_nonlinearity", **taps)
    train, test = simulation.of(EVEN), simulation.of(ODD)
    assert refined(train, test, chosen(train, wave), FORMS).forms[0].free == pattern.free


def test_an_earlier_effect_gives_up_what_another_came_to_say(drawn):
    """A drift whose zero lies within the session, and an offset beside it: one of the two says it."""
    simulation = drawn(6, "time_zero_offset", delay=6e-11)
    drift = next(f for f in FORMS if f.effect.id == "time_zero_drift" and f.free == ("rate", "zero_at"))
    offset = common("time_zero_offset")
    both = fit(simulation, (drift, offset), np.concatenate([fit_nominal(simulation).x, drift.at_start(), [1.0]]))
    found = plainer(simulation, both, FORMS)
    assert [form.free for form in found.forms] == [("rate",), ("delay",)]
    assert found.deviance == pytest.approx(both.deviance, abs=3)


def test_an_earlier_effect_has_one_number_where_zones_are_alike(drawn):
    """Its zones had differed for want of what came beside it."""
    simulation = drawn(6, "ambient_pedestal", level=3.0)
    pedestal = next(f for f in FORMS if f.effect.id == "ambient_pedestal" and f.own == ("level",))
    offset = common("time_zero_offset")
    both = fit(simulation, (pedestal, offset), np.concatenate([fit_nominal(simulation).x, pedestal.at_start(), [0.0]]))
    found = plainer(simulation, both, FORMS)
    assert (found.forms[0].free, found.forms[0].own) == (("level",), ())
    assert found.settings[0].values["level"] == pytest.approx(3, abs=0.2)


def test_an_earlier_effect_keeps_what_nothing_else_says(drawn):
    simulation = drawn(6, "ambient_pedestal", level=[0.0, 2.0, 6.0, 1.0])
    pedestal = next(f for f in FORMS if f.effect.id == "ambient_pedestal" and f.own == ("level",))
    offset = common("time_zero_offset")
    x = np.concatenate([fit_nominal(simulation).x, pedestal.at_start(), [0.0]])
    both = fit(simulation, (pedestal, offset), x)
    assert plainer(simulation, both, FORMS) is both


def test_the_last_effect_gives_up_what_does_not_earn_its_price(drawn):
    """Of forms of one effect with the same strengths not all are tried: one with more in it may have been."""
    simulation = drawn(7, "impulse_tail", share=0.2, tau=5e-10)
    train, test = simulation.of(EVEN), simulation.of(ODD)
    heavy = next(f for f in FORMS if f.free == ("share", "tau", "heavy") and not f.own and f.start["heavy"] < 0)
    more = chosen(train, heavy)
    found = refined(train, test, more, FORMS)
    assert found.forms[0].free == ("share", "tau")
    assert found.settings[0].values["heavy"] == 0
    assert found.deviance == pytest.approx(more.deviance, abs=6)


def test_zones_are_divided_where_frames_held_out_agree_and_only_once(drawn):
    simulation = drawn(3, "ambient_pedestal", level=[0.0, 2.0, 6.0, 1.0])
    train, test = simulation.of(EVEN), simulation.of(ODD)
    forms = [common("ambient_pedestal")]
    found = next(enlarged(train, test, chosen(train, forms[0]), forms))
    assert found.forms[-1].own == ("level",)
    np.testing.assert_allclose(found.settings[0].values["level"], [0, 2, 6, 1], atol=0.5)
    assert not list(enlarged(train, test, found, forms))
    assert not list(enlarged(train, test, chosen(train, common("footprint_blur")), [common("footprint_blur")]))
    # Fitted to one half of one recording, and judged by a quite different one.
    other = drawn(5, "ambient_pedestal", level=[6.0, 2.0, 0.0, 3.0]).of(ODD)
    assert not list(enlarged(train, other, chosen(train, forms[0]), forms))


def test_a_richer_form_that_earns_its_price_needs_nothing_left_on_frames_that_chose(drawn):
    """A saw-tooth in the phase of whole pulses, which a cosine hardly leaves anything of."""
    simulation = drawn(3, "bin_phase", whole=0.3, phase=0.1, sin_2=0.4, cos_3=-0.3)
    train, test = simulation.of(EVEN), simulation.of(ODD)
    forms = [form for form in FORMS if form.effect.id == "bin_phase"]
    plain = next(form for form in forms if form.free == ("whole", "phase") and not form.own)
    fits = list(enlarged(train, test, chosen(train, plain), forms))
    assert "sin_2" in fits[-1].forms[-1].free
    assert fits[-1].settings[0].values["sin_2"] == pytest.approx(0.4, abs=0.15)


def test_a_plainer_form_that_cannot_be_is_left(drawn, monkeypatch):
    """Where counts cannot be as they would be there it is no form to begin with, and no reason to stop."""
    simulation = drawn(6, "ambient_pedestal", level=[0.0, 2.0, 6.0, 1.0])
    pedestal = next(f for f in FORMS if f.effect.id == "ambient_pedestal" and f.own == ("level",))
    found = chosen(simulation, pedestal)

    def refused(*_):
        raise Refusal("counts are below 0, expected 0 or more")

    monkeypatch.setattr("mismatch.refined.Descent", refused)
    assert plainer(simulation, found, FORMS) is found


def test_a_blur_that_is_let_be_longer_one_way_begins_as_it_was(drawn):
    """Alike along both axes: where it begins, counts are those of the blur that was found."""
    simulation = drawn(3)
    first = next(f for f in forms_of(find_effect("footprint_blur"), {"zone": 4, "bin": 48}) if f.free == ("variance",))
    before = fit(simulation, (first,), np.append(fit_nominal(simulation).x, first.at_start()), most_steps=0)
    longer = next(f for f in richer(first, all_forms({"zone": 4, "bin": 48})) if f.free == ("variance", "taller"))
    begun = longer.setting(longer.coordinates_from(first, before.settings[0]))
    np.testing.assert_array_equal(simulation.expected(before.gain, (begun,)), before.expected)

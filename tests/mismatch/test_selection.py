"""What is tried beside a fit, and what may stand in for an effect that took a richer form."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from mismatch import selection
from mismatch.fit import fit, fit_nominal
from mismatch.form import all_forms, forms_of
from mismatch.refined import enriched
from mismatch.rivals import rivals
from mismatch.selection import _leaving, _likeliest_way, others_than, select
from physics.effects import find_effect

SIZES = {"zone": 4, "bin": 48}


def test_effects_that_were_found_are_not_tried_again():
    forms = all_forms(SIZES)
    found = SimpleNamespace(forms=tuple(f for f in forms if f.effect.id in ("interference", "pile_up"))[:2])
    left = {form.effect.id for form in others_than(found, forms)}
    assert {form.effect.id for form in forms} - left == {form.effect.id for form in found.forms}


def test_rivals_are_looked_for_although_the_form_grew_richer(drawn):
    simulation = drawn(5, "impulse_tail", share=0.1, tau=4e-10)
    train, test = simulation.of(np.arange(0, 24, 2)), simulation.of(np.arange(1, 24, 2))
    names = ("impulse_tail", "afterpulsing", "time_zero_offset")
    forms = [form for name in names for form in forms_of(find_effect(name), SIZES)]
    rounds = select(train, test, forms)
    assert rounds[0].chosen.form.effect.id == "impulse_tail"
    (form, *_) = forms_of(find_effect("impulse_tail"), SIZES)
    now = fit(train, (form,), np.concatenate([fit_nominal(train).x, form.at_start()]))
    # The same effect, but not the form that the round chose.
    assert form is not rounds[0].chosen.form
    found = [rival.form.effect.id for rival in rivals(train, test, now, form, rounds, forms)]
    close = {c.form.effect.id for c in rounds[0].candidates}
    assert found[0] == "impulse_tail"
    assert set(found) <= close
    assert len(found) == len(set(found))


def test_a_rival_gains_the_parameter_it_lacked(drawn):
    """Aliased pulses that are smeared, of which the form without a smear was fitted."""
    simulation = drawn(5, "range_aliasing", counts=60.0, apparent_range=0.55, jitter=1.5e-9)
    train = simulation.of(np.arange(0, 24, 2))
    forms = list(forms_of(find_effect("range_aliasing"), SIZES))
    plain = next(form for form in forms if form.free == ("counts", "apparent_range") and not form.own)
    plain = replace(plain, start=plain.start | {"apparent_range": 0.55, "counts": 60.0})
    fitted = fit(train, (plain,), np.concatenate([fit_nominal(train).x, plain.at_start()]))
    found = enriched(train, fitted, forms)
    assert "jitter" in found.forms[0].free
    assert found.deviance < fitted.deviance - 20


@pytest.mark.parametrize(("own", "strengths", "behind", "richer", "left", "kept"), [
    (("apart",), ("error",), 100.0, 8.0, (), "error"),
    (("apart",), ("error",), 100.0, 12.0, (), "apart"),  # It is likelier with a number for each zone.
    (("apart",), ("error",), 130.0, 8.0, (), "apart"),  # Too far behind to be tried.
    ((), ("error",), 100.0, 8.0, ("a place",), "apart"),  # The same with more said of it is tried in any case.
    ((), ("haze",), 100.0, 8.0, ("a place",), "error"),  # What is strong is another.
    ((), ("haze",), 100.0, 8.0, (), "apart"),  # Nothing is left for it.
])  # fmt: skip
def test_another_way_of_an_effect_gets_its_chance(monkeypatch, own, strengths, behind, richer, left, kept):
    """Made richer, beside a number for each zone or another strength."""
    effect = SimpleNamespace(id="clock")

    def found(name, own, criterion):
        strong = strengths if name == "apart" else ("error",)
        form = SimpleNamespace(effect=effect, own=own, name=name, strengths=strong)
        return SimpleNamespace(form=form, criterion=criterion, fit=SimpleNamespace(name=name, forms=[form]))

    best, plain, worse = found("apart", own, 20.0), found("error", (), 20.0 + behind), found("warmup", (), 200.0)
    ends = {"apart": 10.0, "error": richer, "warmup": 0.0}
    monkeypatch.setattr(selection, "refined", lambda train, test, fit, forms: SimpleNamespace(
        name=fit.name, deviance=ends[fit.name]))  # fmt: skip
    monkeypatch.setattr(selection, "cost", lambda train, fit: 0.0)
    monkeypatch.setattr(selection, "what_is_left", lambda train, fit: left)
    assert _likeliest_way(None, None, [], best, [best, worse, plain]).name == kept


def test_each_other_strength_that_came_near_gets_its_chance(monkeypatch):
    """Not only the nearest: that of a blur may lose light at the rim, which that of a haze has no word for."""
    effect = SimpleNamespace(id="blur")

    def found(name, criterion):
        form = SimpleNamespace(effect=effect, own=(), name=name, strengths=(name,))
        return SimpleNamespace(form=form, criterion=criterion, fit=SimpleNamespace(name=name, forms=[form]))

    ways = [found(name, far) for name, far in (("haze", 20.0), ("steeper", 40.0), ("variance", 90.0), ("far", 200.0))]
    ends = {"haze": 10.0, "steeper": 12.0, "variance": 5.0, "far": 0.0}
    monkeypatch.setattr(selection, "refined", lambda train, test, fit, forms: SimpleNamespace(
        name=fit.name, deviance=ends[fit.name]))  # fmt: skip
    monkeypatch.setattr(selection, "cost", lambda train, fit: 0.0)
    monkeypatch.setattr(selection, "what_is_left", lambda train, fit: ("a place",))
    assert _likeliest_way(None, None, [], ways[0], ways).name == "variance"


@pytest.mark.parametrize(("name", "part"), [("mirrored_zones", 0.25), ("range_walk", 1.0)])
def test_an_effect_that_all_would_write_alike_leaves_less(name, part):
    form = SimpleNamespace(effect=find_effect(name))
    assert _leaving(SimpleNamespace(form=form, observed=800.0)) == part * 800
    # However much exchanged zones gain, there is no other way to exchange them.
    assert (_leaving(SimpleNamespace(form=form, observed=1e6)) < 1e4) == (part < 1)


@pytest.mark.parametrize(("short", "hidden", "enough", "asked", "first"), [
    (True, 5.0, False, ["louder", "quieter"], "quieter"),
    (True, 20.0, False, ["louder", "quieter"], "louder"),  # Another that fits worse takes no place.
    (False, 5.0, False, ["louder"], "louder"),
    (True, 5.0, True, ["louder"], "louder"),  # Unless enough was done with the first.
])  # fmt: skip
def test_what_falls_short_hides_nothing_that_promises_less(monkeypatch, short, hidden, enough, asked, first):
    fits = {"louder": 10.0, "quieter": hidden}
    scores = [
        SimpleNamespace(form=SimpleNamespace(effect=SimpleNamespace(id=name, exact=False)), log_p=-99.0)
        for name in fits
    ]
    tried = []

    def candidates_among(train, test, before, promising, many):
        form = promising[0].form
        tried.append(form.effect.id)
        train.work.enough = enough
        judged = {"observed": 0.0, "falls_short": short, "stands_out": lambda many: True}
        return [SimpleNamespace(form=form, criterion=fits[form.effect.id], **judged)]

    train, now = SimpleNamespace(work=SimpleNamespace(enough=False)), SimpleNamespace(forms=())
    monkeypatch.setattr(selection, "ranked", lambda train, now, forms: ([] if now is None else scores, len(fits)))
    monkeypatch.setattr(selection, "candidates_among", candidates_among)
    monkeypatch.setattr(selection, "_likeliest_way", lambda *_: SimpleNamespace(forms=()))
    monkeypatch.setattr(selection, "refreshed", lambda train, found: None)
    monkeypatch.setattr(selection, "others_than", lambda fitted, forms: forms)
    one = selection.onward(train, None, [], [], now)[0]
    assert (tried, one.chosen.form.effect.id) == (asked, first)

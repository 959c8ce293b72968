"""What is tried beside a fit, and what may stand in for an effect that took a richer form."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from mismatch.fit import fit, fit_nominal
from mismatch.form import all_forms, forms_of
from mismatch.poisson import deviance
from mismatch.refined import enriched
from mismatch.rivals import rivals
from mismatch.score import Score
from mismatch.selection import _leaving, most_promising, others_than, select, to_be_gained
from physics.effects import find_effect

SIZES = {"zone": 4, "bin": 48}


def test_effects_that_were_found_are_not_tried_again():
    forms = all_forms(SIZES)
    found = SimpleNamespace(forms=tuple(f for f in forms if f.effect.id in ("interference", "pile_up"))[:2])
    left = {form.effect.id for form in others_than(found, forms)}
    assert {form.effect.id for form in forms} - left == {form.effect.id for form in found.forms}


@pytest.mark.parametrize("level", [1.0, 30.0])
def test_noise_leaves_little_to_be_gained_and_a_misfit_what_it_makes(level):
    """Counts drawn around what is expected, few or many; and around other ones, whose divergence is to be gained."""
    rng = np.random.default_rng(4)
    mean = np.full((40, 9, 60), level)
    truth = mean * np.where(np.arange(60) < 30, 1.5, 1.0)

    def fitted(counts):
        return SimpleNamespace(expected=mean, deviance=float(deviance(counts, mean).sum()))

    scatter = np.sqrt(np.var([fitted(rng.poisson(mean)).deviance for _ in range(30)]))
    assert 0 < to_be_gained(fitted(rng.poisson(mean))) < 8 * scatter
    due = 2 * float((truth * np.log(truth / mean) - truth + mean).sum())
    # Where few are expected noise itself makes more than it would, were the fit right.
    assert due - 2 * scatter < to_be_gained(fitted(rng.poisson(truth))) < 5 * due


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


def scores(*promised):
    """Scores of forms of effects by name, that look or not, and promise so much; best first."""
    made = []
    for name, looks, gain in sorted(promised, key=lambda one: -one[2]):
        effect = SimpleNamespace(id=name)
        # By zone, as the name says.
        own = ("passed",) if name == "by zone" else ()
        alike = {"own": own, "strengths": ("passed",)}
        form = SimpleNamespace(effect=effect, **alike, looks=looks)
        made.append(Score(form, np.ones(1), gain, 0, 0.0, 0.0))
    return made


def test_what_promises_more_than_there_is_to_gain_hides_nothing_that_looks():
    found = scores(
        ("aliasing", False, 9e5),
        ("other", False, 8e5),
        ("other", False, 7e5),
        ("other", False, 6e5),
        ("other", True, 2e4),
    )
    kept = most_promising(found, 3e4)
    assert [(one.form.effect.id, one.gain) for one in kept] == [
        ("aliasing", 9e5), ("other", 8e5), ("other", 7e5), ("other", 2e4)
    ]  # fmt: skip
    # Were there as much to gain as is promised, what looks would be too little.
    assert len(most_promising(found)) == 3


@pytest.mark.parametrize(("numbers", "kept"), [(128, {"widths", "fog"}), (1, {"widths"})])
def test_what_many_numbers_gain_from_noise_hides_nothing(numbers, kept):
    """A width for each of 128 bins gains 128 where nothing is amiss; beyond that, 72, it hides no gain of 52."""
    widths, fog = scores(("widths", False, 200.0), ("fog", False, 52.0))
    found = most_promising([replace(widths, dof=numbers), replace(fog, dof=2)])
    assert {one.form.effect.id for one in found} == kept


def test_one_value_for_all_zones_is_tried_beside_a_value_for_each():
    found = scores(*(("by zone", False, gain) for gain in (9.0, 8.0, 7.0)))
    alike = scores(("by zone", False, 6.0), ("by zone", False, 5.0))
    for one in alike:
        one.form.own = ()
    assert [one.gain for one in most_promising([*found, *alike])] == [9.0, 8.0, 6.0]
    # Also where another way of being there, with a value for each, has come between.
    found[2].form.strengths = ("counts",)
    assert [one.gain for one in most_promising([*found, *alike])] == [9.0, 8.0, 7.0, 6.0]
    # And where that has the same value for all.
    found[2].form.own = ()
    assert [one.gain for one in most_promising([*found, *alike])] == [9.0, 8.0, 7.0, 6.0]


def test_each_way_of_being_there_is_tried():
    found = scores(*(("other", False, gain) for gain in (9.0, 8.0, 7.0, 6.0, 5.0, 4.0)))
    for one, strength in zip(found, ("passed", "passed", "passed", "covered", "covered", "one"), strict=True):
        one.form.strengths = (strength,)
    assert [one.gain for one in most_promising(found)] == [9.0, 8.0, 6.0, 4.0]


@pytest.mark.parametrize(("name", "part"), [("mirrored_zones", 0.25), ("range_walk", 1.0)])
def test_an_effect_that_all_would_write_alike_leaves_less(name, part):
    form = SimpleNamespace(effect=find_effect(name))
    assert _leaving(SimpleNamespace(form=form, observed=800.0)) == part * 800
    # However much exchanged zones gain, there is no other way to exchange them.
    assert (_leaving(SimpleNamespace(form=form, observed=1e6)) < 1e4) == (part < 1)

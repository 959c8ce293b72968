"""Zones that arrive late and another pulse: what is chosen first may be neither."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from mismatch.exchanged import exchanged
from mismatch.fit import fit, fit_nominal
from mismatch.form import forms_of
from mismatch.score import Score
from mismatch.selection import Round
from physics.effects import find_effect

SIZES = {"zone": 4, "bin": 48}
FORMS = [
    form for name in ("time_zero_offset", "range_walk", "zone_gain") for form in forms_of(find_effect(name), SIZES)
]


def beginning(train, *names):
    """A selection that ended with the first form, by zone, of each of these effects."""
    found = [next(f for f in FORMS if f.effect.id == name and f.own) for name in names]
    now = fit_nominal(train)
    rounds = []
    for i, form in enumerate(found):
        x = np.concatenate([now.x, form.at_start()])
        then = fit(train, tuple(found[: i + 1]), x)
        rounds.append(Round(now, (), 1, (), SimpleNamespace(form=form, fit=then, observed=100.0)))
        now = then
    return [*rounds, Round(now, (), 1, (), None)]


@pytest.fixture
def parts(rig, simulated):
    late = find_effect("time_zero_offset").at(delay=np.array([3e-11, -4e-11, 2e-11, -1e-11]))
    weak = find_effect("zone_gain").at(factor=np.array([1.1, 0.9, 1.0, 1.05]))
    simulation = simulated(np.random.default_rng(3).poisson(rig.expected(late, weak)))
    return simulation.of(np.arange(0, 24, 2)), simulation.of(np.arange(1, 24, 2))


@pytest.mark.parametrize("first", ["range_walk", "time_zero_offset"])
def test_what_came_first_gives_way_to_what_is_likelier_beside_the_last(parts, first):
    train, test = parts
    rounds = [replace(one, chosen=scored(one.chosen)) for one in beginning(train, first, "zone_gain")]
    found = exchanged(train, test, FORMS, rounds)
    assert {form.effect.id for form in found[-1].before.forms} == {"time_zero_offset", "zone_gain"}
    assert (found is rounds) == (first == "time_zero_offset")
    if found is not rounds:
        # It may stand in the place of what it gave way to.
        (came,) = [one for one in found if one.chosen is not None and one.chosen.form.effect.id == "time_zero_offset"]
        (was,) = [c for c in came.candidates if c.form.effect.id == first]
        assert [form.effect.id for form in was.fit.forms] == ["zone_gain", first]


def test_one_effect_is_beside_no_other(parts):
    train, test = parts
    rounds = beginning(train, "range_walk")
    assert exchanged(train, test, FORMS, rounds) is rounds


def test_what_was_chosen_among_its_own_forms_is_held_against_others(parts):
    train, test = parts
    rounds = [replace(one, chosen=scored(one.chosen)) for one in beginning(train, "zone_gain", "range_walk")]
    found = exchanged(train, test, FORMS, rounds, own=True)
    assert {form.effect.id for form in found[-1].before.forms} == {"time_zero_offset", "zone_gain"}


def test_what_may_stand_in_the_place_of_the_first_was_tried_beside_the_last(parts, monkeypatch):
    train, test = parts
    monkeypatch.setattr("mismatch.exchanged.ODDS", np.inf)
    rounds = beginning(train, "range_walk", "zone_gain")
    found = exchanged(train, test, FORMS, [replace(one, chosen=scored(one.chosen)) for one in rounds])
    assert [form.effect.id for form in found[-1].before.forms] == ["range_walk", "zone_gain"]
    first = found[0]
    assert [form.effect.id for form in first.before.forms] == ["zone_gain"]
    assert first.chosen is first.candidates[0]
    assert [form.effect.id for form in first.chosen.fit.forms] == ["zone_gain", "range_walk"]
    assert first.chosen.fit.deviance == pytest.approx(found[-1].before.deviance, rel=1e-9)
    assert {c.form.effect.id for c in first.candidates[1:]} == {"time_zero_offset"}


def test_what_was_chosen_in_a_form_that_others_belie_takes_another(rig, simulated):
    """A tail of the detector, which was taken for a laser that lingers while zones' gains were as they should be."""
    tail, weak = find_effect("impulse_tail"), find_effect("zone_gain").at(factor=np.array([1.3, 0.8, 1.0, 1.1]))
    simulation = simulated(np.random.default_rng(3).poisson(rig.expected(tail.at(share=0.2, tau=6e-10), weak)))
    train, test = simulation.of(np.arange(0, 24, 2)), simulation.of(np.arange(1, 24, 2))
    forms = [*forms_of(tail, SIZES), *forms_of(weak.effect, SIZES)]
    lingering = next(f for f in forms if f.free == ("lingering", "duration"))
    gains = next(f for f in forms if f.effect is weak.effect and f.own)
    now = fit_nominal(train)
    then = fit(train, (lingering,), np.concatenate([now.x, lingering.at_start()]))
    last = fit(train, (lingering, gains), np.concatenate([then.x, gains.at_start()]))
    chosen = [SimpleNamespace(form=f, fit=at, observed=100.0) for f, at in ((lingering, then), (gains, last))]
    rival = SimpleNamespace(form=gains, fit=then)
    rounds = [Round(now, (), 1, (rival,), chosen[0]), Round(then, (), 1, (), chosen[1]), Round(last, (), 1, (), None)]
    found = exchanged(train, test, forms, rounds)
    assert {form.free for form in found[-1].before.forms} == {("share", "tau"), ("factor",)}
    anew = next(one for one in found if one.chosen is not None and one.chosen.form.effect is tail)
    assert rival in anew.candidates


def scored(chosen):
    """What was chosen, with a score."""
    return chosen and SimpleNamespace(**vars(chosen), score=Score(chosen.form, np.ones(4), 1.0, 4, -1.0, 1.0))

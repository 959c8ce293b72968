"""Other forms of the last effect of a fit, where all frames say that they are likelier; and where rivals begin."""

from types import SimpleNamespace

import numpy as np

from mismatch.fit import fit, fit_nominal
from mismatch.form import all_forms
from mismatch.rivals import CLOSE, begun_from, evidence, likelier_forms

FORMS = all_forms({"zone": 4, "bin": 48})
EVEN, ODD = np.arange(0, 24, 2), np.arange(1, 24, 2)


def test_richer_forms_that_all_frames_say_are_likelier_come_in_order(drawn):
    """A pedestal that grows, taken for one that stays: so it is told in each form that lets it grow."""
    simulation = drawn(3, "ambient_pedestal", level=3.0, growth=0.3)
    train, test = simulation.of(EVEN), simulation.of(ODD)
    steady = next(form for form in FORMS if form.effect.id == "ambient_pedestal" and form.free == ("level",))
    one = fit(train, (steady,), np.concatenate([fit_nominal(train).x, steady.at_start()]))
    found = likelier_forms(train, test, one, FORMS)
    told = [evidence(train, test, other) for other in found]
    assert found
    assert told == sorted(told, reverse=True)
    assert told[-1] > evidence(train, test, one)
    assert all(set(other.forms[-1].free) > {"level"} for other in found[:1])


def test_what_is_right_has_hardly_a_likelier_form(drawn):
    simulation = drawn(4, "ambient_pedestal", level=3.0)
    train, test = simulation.of(EVEN), simulation.of(ODD)
    steady = next(form for form in FORMS if form.effect.id == "ambient_pedestal" and form.free == ("level",))
    one = fit(train, (steady,), np.concatenate([fit_nominal(train).x, steady.at_start()]))
    least = evidence(train, test, one)
    assert all(evidence(train, test, other) < least + 6 for other in likelier_forms(train, test, one, FORMS))


def test_a_rival_begins_from_the_plainest_of_its_effect_that_comes_near_too():
    def rival(effect, numbers, evidence, way="x"):
        form = SimpleNamespace(effect=effect, coordinates=range(numbers), strengths=(way,))
        return SimpleNamespace(form=form, evidence=evidence)

    shift, blur = object(), object()
    turned, moved, half = rival(shift, 3, 0.0), rival(shift, 2, 1 - CLOSE), rival(shift, 1, -1 - CLOSE)
    found = [turned, moved, half, rival(blur, 1, -1.0)]
    assert begun_from(turned, found) == [turned, moved]
    assert begun_from(moved, [moved, half]) == [moved, half]
    assert begun_from(half, [half]) == [half]
    # And from the best in each other way of being there that does.
    others = [rival(shift, 5, value, "slip") for value in (-9.0, -8.0, -1 - CLOSE)]
    assert begun_from(turned, [*found, *others]) == [turned, moved, others[1]]

"""Fits side by side against each fitted alone to its end."""

import numpy as np
import pytest

from mismatch.descent import MOST_STEPS, Descent
from mismatch.fit import fit, fit_nominal, reached
from mismatch.form import forms_of
from mismatch.race import race
from mismatch.work import MOST_RENDERINGS
from physics.effects import find_effect

from .conftest import BINS, ZONES


def begun(simulation, *names):
    """A descent for the first form of each effect, from its start, and the form."""
    nominal = fit_nominal(simulation)
    forms = [next(f for f in forms_of(find_effect(n), {"zone": ZONES, "bin": BINS}) if not f.own) for n in names]
    return [Descent(simulation, (form,), np.concatenate([nominal.x, form.at_start()]), 0.0) for form in forms]


def test_a_descent_in_parts_is_the_fit_in_one(drawn):
    simulation = drawn(1, "impulse_tail", share=0.1, tau=4e-10)
    (parts,) = begun(simulation, "impulse_tail")
    alone = fit(simulation, parts.forms, parts.x)
    while not parts.over:
        parts.run(1)
    assert (reached(parts).x == alone.x).all()
    assert reached(parts).deviance == alone.deviance


def test_what_cannot_win_is_left_and_the_best_is_as_if_alone(drawn):
    simulation = drawn(2, "impulse_tail", share=0.2, tau=6e-10)
    names = ("impulse_tail", "ambient_pedestal", "gain_drift", "zone_gain")
    descents = begun(simulation, *names)
    alone = [fit(simulation, d.forms, d.x) for d in descents]
    left = race(descents, [5.0 * len(d.x) for d in descents])
    assert 0 not in left
    assert descents[0].over
    assert reached(descents[0]).deviance == alone[0].deviance
    for i, descent in enumerate(descents):
        # Who was left would have come nowhere near.
        if i in left:
            assert alone[i].deviance > alone[0].deviance + 60
        else:
            assert descent.deviance == alone[i].deviance


def test_what_comes_nowhere_near_another_is_left(drawn):
    """As in one race with it; what would come near runs to its end."""
    simulation = drawn(2, "impulse_tail", share=0.2, tau=6e-10)
    tail, pedestal = begun(simulation, "impulse_tail", "ambient_pedestal")
    best = fit(simulation, tail.forms, tail.x).deviance
    assert race([pedestal], [0.0], best) == [0]
    assert race([tail], [0.0], best) == []
    assert tail.over
    assert reached(tail).deviance == best


def test_far_beyond_enough_work_only_what_leads_is_finished(drawn):
    """Of two alike, which would come to the same, one is left where it was."""
    simulation = drawn(2, "impulse_tail", share=0.2, tau=6e-10)
    near, same = begun(simulation, "impulse_tail", "impulse_tail")
    best = fit(simulation, near.forms, near.x).deviance
    simulation.work.renderings = 10 * MOST_RENDERINGS
    assert race([near, same], [0.0, 1e-6]) == [1]
    assert near.over
    assert not same.over
    assert reached(near).deviance == best


def test_hope_is_no_less_than_what_a_fit_comes_to(drawn):
    simulation = drawn(3, "time_zero_offset", delay=1e-10)
    (descent,) = begun(simulation, "time_zero_offset")
    assert descent.hoped == -np.inf
    end = fit(simulation, descent.forms, descent.x).deviance
    while not descent.over:
        descent.run(1)
        assert descent.hoped <= end + 1e-6


@pytest.mark.parametrize("count", [0, 1])
def test_one_alone_runs_to_its_end_and_none_are_none(drawn, count):
    descents = begun(drawn(4), *["ambient_pedestal"] * count)
    assert race(descents, [0.0] * count) == []
    assert all(descent.over for descent in descents)


def test_a_descent_ends_after_so_many_steps(drawn):
    (descent,) = begun(drawn(5), "range_walk")
    assert descent.run(10 * MOST_STEPS).over

"""When a second effect is a cause of its own, and when it may be another formula of the first."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from mismatch.candidates import Candidate, candidates_of, elsewhere
from mismatch.fit import fit, fit_nominal
from mismatch.form import forms_of
from mismatch.score import Score
from mismatch.work import MOST_RENDERINGS, Work
from physics.effects import find_effect

SIZES = {"zone": 4, "bin": 48}


def of(observed, expected, away, looks=False):
    fitted = SimpleNamespace(settings=(SimpleNamespace(effect=SimpleNamespace(looks=lambda _: looks), values={}),))
    return Candidate(None, fitted, 0.0, 0.0, 9.0, observed, expected, 2 * max(expected, 1) ** 0.5, away)


@pytest.mark.parametrize(
    ("observed", "expected", "away", "won", "minor"),
    [
        (100, 100, 0.0, 1000, False),  # A tenth of what the first gained.
        (64, 64, 0.0, 1000, True),  # Less than that, and where the first acts.
        (64, 64, 0.9, 1000, False),  # The same where it does not.
        (99, 123, 0.0, 1265, False),  # As much as can be told to be what it should.
        (99, 175, 0.0, 1265, False),  # Both halves scatter: 76 apart, by 37.
        (99, 205, 0.0, 1265, True),  # Less than it should.
        (38, 40, 0.9, 1000, False),  # Little, but as it should be.
        (
            38,
            66,
            0.9,
            1000,
            False,
        ),  # Little, and less than it should be, as one of ten is.
        (38, 66, 0.0, 100, True),  # The same where it does.
        (38, 90, 0.9, 1000, True),  # Little, and less than one of 20 would be.
        (25, 25, 1.0, 1000, True),  # Too little in any case.
        (40, 40, 0.0, 100, False),
        (1100, 1150, 0.0, 70000, False),  # A hundredth, but as it should be to a twentieth.
        (1100, 1250, 0.0, 70000, True),  # Not quite.
        (600, 600, 0.0, 70000, True),
        # What gains far more than it should is another cause's trace; by a little, chance.
        (127, 19, 1.0, 1000, True),
        (267, 63, 1.0, 1000, True),
        (188, 133, 1.0, 1000, False),
        (104, 51, 1.0, 167, False),  # Both halves scatter: 53 apart, by 25.
        (120, 51, 1.0, 167, True),
    ],
)
def test_what_is_minor(observed, expected, away, won, minor):
    assert of(observed, expected, away).is_minor(won) == minor


@pytest.mark.parametrize(
    ("observed", "away", "won", "minor"),
    [
        (99, 1.0, 1000, True),
        (101, 1.0, 1000, False),
        (150, 1.0, 2000, False),
        (150, 0.5, 2000, True),
        (170, 0.5, 2000, False),
    ],
)
def test_a_third_is_less_likely_beforehand(observed, away, won, minor):
    """And where the two others act it may be another formula of theirs, however well it is as expected."""
    assert of(observed, observed, away).is_minor(won, others=2) == minor
    assert not of(observed, observed, away).is_minor(won)


def test_what_is_elsewhere_is_counted_cell_by_cell(drawn):
    simulation = drawn(3, "impulse_tail", share=0.15, tau=4e-10)
    (tail, *_), (other, *_) = (list(forms_of(find_effect(name), SIZES)) for name in ("impulse_tail", "range_walk"))
    before = fit(simulation, (tail,), np.concatenate([fit_nominal(simulation).x, tail.at_start()]))
    fitted = fit(simulation, (tail, other), np.concatenate([before.x, other.at_start()]))
    first = before.expected - simulation.expected(before.gain)
    change = fitted.expected - simulation.expected(fitted.gain, fitted.settings[:1])
    total = own = 0.0
    for cell in np.ndindex(change.shape):
        size = change[cell] ** 2 / max(before.expected[cell], 1e-3)
        total += size
        own += size * (abs(change[cell]) > abs(first[cell]))
    assert elsewhere(simulation, before, fitted) == pytest.approx(own / total)
    assert 0 < own < total


def test_what_has_come_to_nothing_does_not_stand_out():
    """Its trace may fit frames held out though what is left of it gains nothing: it would end the search."""
    fitted = SimpleNamespace(settings=[SimpleNamespace(effect=find_effect("window_clipping"), values={})])
    for observed, stands in ((0.01, False), (30.0, True)):
        assert (
            Candidate(None, fitted, 0.0, 0.0, 6.0, observed, observed, 2 * max(observed, 1) ** 0.5, 1.0).stands_out(10)
            == stands
        )


def test_what_looks_at_each_frame_may_have_been_shown_more_on_those_held_out():
    """By three standard deviations more than twice what is due, and not by five."""
    for more, minor in ((3.0, False), (5.0, True)):
        observed = 100 + more * 2 * 100**0.5 * 2**0.5 + 100
        one = of(observed, 100, 1.0, looks=True)
        assert replace(one, scatter=(observed - 100) / (more * 2**0.5)).is_minor(300) == minor
        assert replace(of(observed, 100, 1.0), scatter=(observed - 100) / (more * 2**0.5)).is_minor(300)


def test_the_best_of_each_effect_is_fitted_as_its_other_way_has_it(drawn):
    """A walk that goes by all of a histogram, begun as one that goes by its fullest bin, is found as it is.

    Also where another effect comes nearer than the walk as it was begun.
    """
    simulation = drawn(3, "range_walk", walk=0.0, logarithmic=4e-11, level=100.0)
    form = next(f for f in forms_of(find_effect("range_walk"), SIZES) if f.free == ("logarithmic", "level"))
    nominal = fit_nominal(simulation)
    right, wrong = (
        Score(replace(form, start=form.start | {"level": 100.0, "fullest": fullest}), np.ones(1), 99.0, 1, -50.0, 99.0)
        for fullest in (0.0, 1.0)
    )
    (alone,) = candidates_of(simulation, simulation, nominal, [wrong])
    best, second = candidates_of(simulation, simulation, nominal, [replace(wrong, other=right)])
    assert second.criterion == alone.criterion
    # Not where enough was done.
    busy = replace(simulation, work=Work(2 * MOST_RENDERINGS))
    assert len(candidates_of(busy, busy, nominal, [replace(wrong, other=right)])) == 1
    assert best.fit.settings[-1].values["fullest"] == 0
    assert best.criterion < second.criterion - 10
    late = drawn(3, "time_zero_offset", delay=2e-11)
    offset = next(f for f in forms_of(find_effect("time_zero_offset"), SIZES) if not f.own)
    both = [Score(offset, np.ones(1), 99.0, 1, -50.0, 99.0), replace(wrong, other=right)]
    best, *walks = candidates_of(late, late, fit_nominal(late), both)
    assert best.form.effect.id == "time_zero_offset"
    assert sorted(walk.fit.settings[-1].values["fullest"] for walk in walks) == [0, 1]

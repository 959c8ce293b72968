"""Ranking: every form as it promises by itself, the best start of each."""

from dataclasses import replace

import numpy as np
import pytest

from mismatch import ranking
from mismatch.fit import fit_nominal
from mismatch.form import forms_of
from mismatch.projection import Projection
from mismatch.ranking import best_start, promise, ranked
from mismatch.score import Score
from physics.effects import find_effect

from .conftest import BINS, ZONES


@pytest.fixture
def aliased(drawn):
    return drawn(4, "range_aliasing", counts=30.0, apparent_range=1.0)


def test_forms_that_begin_alike_promise_what_each_would_alone(aliased, monkeypatch):
    forms = list(forms_of(find_effect("range_aliasing"), {"zone": ZONES, "bin": BINS}))
    nominal, asked = fit_nominal(aliased), []
    projection = Projection(aliased, nominal)

    def counted(*args):
        asked.append(args[-1])
        return promise(*args)

    monkeypatch.setattr(ranking, "promise", counted)
    found, tried = ranked(aliased, nominal, forms)
    assert len(asked) < tried
    # Steady, drawing near, on a way of its own, jittered, deep: with one number of counts, and with one for each zone.
    # And what is seen at the end of the window, a period early: with a period that varies and with one that
    # does not; and a thing far off.
    assert len({(s.form.free, s.form.own) for s in found}) == len(found) == 13
    for one in found:
        alone = promise(aliased, nominal, projection, one.form)
        assert (one.gain, one.dof, one.log_p) == (alone.gain, alone.dof, alone.log_p)
        others = (
            promise(aliased, nominal, projection, f) for f in forms if (f.free, f.own) == (one.form.free, one.form.own)
        )
        # Some change nothing where they begin but for the data.
        assert one.gain >= max((other.gain for other in others if other is not None), default=0.0)
    assert all(np.diff([s.log_p for s in found]) >= 0)


def test_the_other_way_of_a_form_is_the_best_start_of_other_given_values():
    form = next(iter(forms_of(find_effect("range_walk"), {"zone": ZONES, "bin": BINS})))

    def promised(gain, **start):
        return Score(replace(form, start=form.start | start), np.ones(1), gain, 1, -gain / 2, gain)

    tried = [promised(90.0, fullest=1.0), promised(100.0), promised(95.0, walk=1e-10), promised(85.0, fullest=0.5)]
    best = best_start(tried)
    assert best.gain == 100.0
    assert best.other is tried[0]  # Where it walks is fitted: beginning there elsewhere is no other way.
    assert best_start([tried[1], promised(70.0, fullest=1.0)]).other is None

"""Ranking: every form as it promises by itself, the best start of each."""

from dataclasses import replace

import numpy as np
import pytest

from mismatch import beside, ranking
from mismatch.beside import Beside
from mismatch.fit import fit_nominal
from mismatch.form import all_forms, forms_of
from mismatch.ranking import best_start, promise, ranked
from mismatch.score import Score
from physics.effects import find_effect

from .conftest import BINS, ZONES


@pytest.fixture
def aliased(drawn):
    return drawn(4, "range_aliasing", counts=30.0, apparent_range=1.0)


def test_forms_that_begin_alike_promise_what_each_would_alone(aliased, monkeypatch):
    forms = list(forms_of(find_effect("range_aliasing"), {"zone": ZONES, "bin": BINS}))
    few = aliased.of(np.arange(0, len(aliased.counts), 2))
    whole, asked = Beside(few, fit_nominal(few)), []

    def counted(*args):
        asked.append(args[1])
        return promise(*args)

    monkeypatch.setattr(ranking, "promise", counted)
    found, tried = ranked(few, whole.fitted, forms)
    assert whole.some is None
    assert len(asked) < tried
    # Steady, steady and deep, drawing near, so and as zones see, on a way of its own of six heights and of twelve,
    # jittered, deep: with one number of counts, and with one for each zone. And what is seen at the end of the window,
    # a period early: with a period that varies and with one that does not; a wall across the view, with either; and a
    # thing far off.
    assert len({(s.form.free, s.form.own) for s in found}) == len(found) == 22
    for one in found:
        alone = promise(whole, one.form)
        assert (one.gain, one.dof, one.log_p) == (alone.gain, alone.dof, alone.log_p)
        others = (promise(whole, f) for f in forms if (f.free, f.own) == (one.form.free, one.form.own))
        # Some change nothing where they begin but for the data.
        assert one.gain >= max((other.gain for other in others if other is not None), default=0.0)
    assert all(np.diff([s.log_p for s in found]) >= 0)


@pytest.mark.parametrize("seed", range(3))
def test_what_stands_out_is_what_stands_out_when_all_frames_are_asked(drawn, monkeypatch, seed):
    simulation = drawn(seed, "impulse_tail", share=0.05, tau=0.6e-9)
    forms, nominal = all_forms({"zone": ZONES, "bin": BINS}), fit_nominal(simulation)
    monkeypatch.setattr(beside, "LARGE", 0)
    quick, tried = ranked(simulation, nominal, forms)
    monkeypatch.setattr(Beside, "some", None)
    exact, all_tried = ranked(replace(simulation), nominal, forms)
    assert tried == pytest.approx(all_tried, rel=0.02)
    # What only some frames were asked of promises little, whatever they say.
    exactly, half = {s.form.name: s.gain for s in exact}, 0.5 * exact[0].beyond_noise
    assert all(s.gain == exactly[s.form.name] or s.beyond_noise < half for s in quick)
    first = [(s.form.name, s.gain) for s in exact if s.beyond_noise > half]
    assert first
    assert dict(first).items() <= {s.form.name: s.gain for s in quick}.items()


def test_what_no_frame_shows_is_as_visible_as_all_frames_show_it(drawn, monkeypatch):
    simulation = drawn(1)
    forms, nominal = all_forms({"zone": ZONES, "bin": BINS}), fit_nominal(simulation)
    monkeypatch.setattr(beside, "LARGE", 0)
    quick, _ = ranked(simulation, nominal, forms)
    monkeypatch.setattr(Beside, "some", None)
    exact, _ = ranked(replace(simulation), nominal, forms)
    information = {s.form.begins_alike: s.information for s in exact}
    ratios = [s.information / information[s.form.begins_alike] for s in quick if s.form.begins_alike in information]
    assert 0.7 < np.median(ratios) < 1.4


def test_the_other_way_of_a_form_is_the_best_start_of_other_given_values():
    form = next(iter(forms_of(find_effect("range_walk"), {"zone": ZONES, "bin": BINS})))

    def promised(gain, **start):
        return Score(replace(form, start=form.start | start), np.ones(1), gain, 1, -gain / 2, gain)

    tried = [promised(90.0, fullest=1.0), promised(100.0), promised(95.0, walk=1e-10), promised(85.0, fullest=0.5)]
    best = best_start(tried)
    assert best.gain == 100.0
    assert best.other is tried[0]  # Where it walks is fitted: beginning there elsewhere is no other way.
    assert best_start([tried[1], promised(70.0, fullest=1.0)]).other is None


def test_numbers_that_the_data_gave_must_earn_their_price():
    form = next(iter(forms_of(find_effect("range_walk"), {"zone": ZONES, "bin": BINS})))

    def promised(gain, **start):
        given = tuple(start)
        return Score(replace(form, start=form.start | start, given=given), np.ones(1), gain, 1, -gain / 2, gain)

    plain, given = promised(100.0), promised(104.0, fullest=0.123)
    assert best_start([plain, given]).gain == 104.0
    best = best_start([plain, given], each=5.0)
    assert best.gain == 100.0
    assert best.other is given
    assert best_start([plain, replace(given, gain=106.0)], each=5.0).gain == 106.0

"""Where fits begin against where scores say, and where fits from there end."""

from dataclasses import replace

import numpy as np
import pytest

from mismatch import beside, head_start
from mismatch.fit import fit, fit_nominal
from mismatch.form import forms_of
from mismatch.head_start import begun, start
from mismatch.ranking import ranked
from mismatch.score import start_of
from physics.effects import find_effect

from .conftest import BINS, ZONES


@pytest.fixture
def tail(drawn):
    """A recording with a tail, and the fit without it."""
    simulation = drawn(1, "impulse_tail", share=0.1, tau=4e-10)
    return simulation, fit_nominal(simulation)


def promised(tail, name):
    """What each form of an effect promises."""
    return ranked(*tail, forms_of(find_effect(name), {"zone": ZONES, "bin": BINS}))[0]


def starts(tail, scores):
    """Descents from where scores say."""
    return [start(*tail, score) for score in scores]


def with_starts(tail, scores):
    """Descents as they begin, each with that from where its score says."""
    return zip(begun(*tail, scores, [0.0] * len(scores)), starts(tail, scores), strict=True)


@pytest.mark.parametrize("times", [1.0, 8.0, 30.0])
def test_a_score_that_says_too_much_is_followed_part_of_the_way(tail, times):
    """Where the whole of it would be worse than nothing."""
    simulation, before = tail
    for score in promised(tail, "ambient_pedestal"):
        there = start(simulation, before, replace(score, amplitude=times * score.amplitude))
        whole = np.concatenate([before.x, start_of(score.form, times * score.amplitude)])
        assert there.deviance < before.deviance
        assert (there.x == whole).all() == (times == 1)


@pytest.mark.parametrize("name", ["impulse_tail", "afterpulsing", "time_zero_offset"])
def test_some_frames_bring_fits_nearly_to_where_they_end(tail, monkeypatch, name):
    simulation, before = tail
    scores = promised(tail, name)
    monkeypatch.setattr(beside, "LARGE", 0)
    for brought, at_score in with_starts(tail, scores):
        end = fit(simulation, at_score.forms, at_score.x, before.frame_gain_sigma).deviance
        assert brought.deviance - end < 0.1 * (before.deviance - end) + 10
        assert brought.run().deviance < end + 1


def test_where_all_frames_cost_little_fits_begin_where_scores_say(tail):
    for brought, at_score in with_starts(tail, promised(tail, "impulse_tail")):
        assert (brought.x == at_score.x).all()


@pytest.mark.parametrize("name", ["time_lag", "bin_nonlinearity"])
def test_what_some_frames_do_not_tell_begins_where_scores_say(tail, monkeypatch, name):
    """What mixes frames, and numbers of many bins."""
    scores = [s for s in promised(tail, name) if s.form.effect.mixes(s.form.start) or s.form.own]
    monkeypatch.setattr(beside, "LARGE", 0)
    assert scores
    for brought, at_score in with_starts(tail, scores):
        assert (brought.x == at_score.x).all()


def test_what_is_worse_than_nothing_is_no_beginning(tail, monkeypatch):
    """As where few frames are another matter than all."""
    scores = promised(tail, "impulse_tail")
    worse = {i: at.x + np.eye(len(at.x))[0] for i, at in enumerate(starts(tail, scores))}
    monkeypatch.setattr(head_start, "_brought", lambda *_: worse)
    for brought, at_score in with_starts(tail, scores):
        assert (brought.x == at_score.x).all()

"""Which of the first round's candidates is tried as the first, and what of it is kept."""

from types import SimpleNamespace

import pytest

from mismatch import beginnings
from mismatch.beginnings import likeliest_selection


def candidate(name, stands_out=True):
    form = SimpleNamespace(effect=SimpleNamespace(id=name))
    return SimpleNamespace(form=form, stands_out=lambda many: stands_out)


@pytest.fixture
def tried(monkeypatch):
    """Selections by what they began with; `likely` says how likely each is, `found` how many effects it has."""
    begun = []
    likely = {"tail": 10.0}
    found = {"tail": 2}

    def selection(name, candidates):
        fitted = SimpleNamespace(forms=("form",) * found.get(name, 2), name=name)
        return [SimpleNamespace(candidates=candidates, chosen=candidates[0], before=fitted)]

    def begun_with(train, test, forms, first, other):
        begun.append(other.form.effect.id)
        return selection(other.form.effect.id, [other])

    candidates = [candidate(n) for n in ("tail", "tail", "walk", "walk")]
    candidates += [candidate("width", False), candidate("fog"), candidate("gain")]
    monkeypatch.setattr(beginnings, "select", lambda *_: selection("tail", candidates))
    monkeypatch.setattr(beginnings, "begun_with", begun_with)
    monkeypatch.setattr(beginnings, "evidence", lambda train, test, fitted: likely.get(fitted.name, 0.0))
    monkeypatch.setattr(beginnings, "what_is_left", lambda train, fitted: ())
    return SimpleNamespace(begun=begun, likely=likely, found=found)


def test_two_others_that_stand_out_are_tried_once_each(tried):
    assert likeliest_selection(None, None, [])[-1].before.name == "tail"
    assert tried.begun == ["walk", "fog"]


@pytest.mark.parametrize("name", ["walk", "fog"])
def test_the_likelier_is_kept(tried, name):
    tried.likely[name] = 11.0
    assert likeliest_selection(None, None, [])[-1].before.name == name


@pytest.mark.parametrize("effects", [0, 1])
def test_where_one_effect_or_none_leaves_nothing_no_other_is_tried(tried, effects):
    tried.found["tail"] = effects
    likeliest_selection(None, None, [])
    assert tried.begun == []


def test_where_one_effect_leaves_something_others_are_tried(tried, monkeypatch):
    tried.found["tail"] = 1
    monkeypatch.setattr(beginnings, "what_is_left", lambda train, fitted: ("a place",))
    likeliest_selection(None, None, [])
    assert tried.begun == ["walk", "fog"]

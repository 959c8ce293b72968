"""Which of the first round's candidates is tried as the first, and what of it is kept."""

from types import SimpleNamespace

import pytest

from mismatch import beginnings
from mismatch.beginnings import likeliest_selection


def candidate(name, stands_out=True):
    form = SimpleNamespace(effect=SimpleNamespace(id=name), own=(), coordinates=[None])
    return SimpleNamespace(form=form, stands_out=lambda many: stands_out)


@pytest.fixture
def tried(monkeypatch):
    """Selections by what they began with.

    likely: how likely each is; minor: what each found too little to name; of the first: how many effects it has,
    whether one is strained or contradicted, what is left. sound: those that leave nothing; alone: whether a cause
    outside does.
    """
    made = SimpleNamespace(begun=[], likely={"tail": 10.0}, effects=2, strained=False, contradiction=None, left=())
    made.minor, made.sound, made.alone = {}, (), False
    effect = SimpleNamespace(
        strained=lambda values, rendering: made.strained, contradiction=lambda values, rendering: made.contradiction
    )

    def selection(name, candidates):
        settings = (SimpleNamespace(effect=effect, values={}, own=(), coordinates=[None]),) * made.effects
        fitted = SimpleNamespace(forms=settings, settings=settings, gain=1.0, name=name)
        minor = made.minor.get(name)
        return [SimpleNamespace(candidates=candidates, chosen=candidates[0], before=fitted, minor=minor)]

    def begun_with(train, test, forms, first, other, richer=True):
        assert richer
        made.begun.append(other.form.effect.id)
        return selection(other.form.effect.id, [other])

    candidates = [candidate(n) for n in ("tail", "tail", "walk", "walk")]
    candidates += [candidate("width", False), candidate("fog"), candidate("gain")]
    monkeypatch.setattr(beginnings, "select", lambda *_: selection("tail", candidates))
    monkeypatch.setattr(beginnings, "begun_with", begun_with)
    monkeypatch.setattr(beginnings, "evidence", lambda train, test, fitted: made.likely.get(fitted.name, 0.0))
    monkeypatch.setattr(beginnings, "exchanged", lambda train, test, forms, rounds, own=False: rounds)
    monkeypatch.setattr(beginnings, "one_in_another_form", lambda train, test, forms, rounds: (rounds, False))
    monkeypatch.setattr(
        beginnings, "what_is_left", lambda train, fitted: () if fitted.name in made.sound else made.left
    )
    monkeypatch.setattr(beginnings, "told_alone", lambda train, test, fitted: made.alone)
    return made


TRAIN = SimpleNamespace(rendering=lambda gain: None, work=SimpleNamespace(enough=False))


def selected():
    return likeliest_selection(TRAIN, None, [])[-1].before.name


@pytest.mark.parametrize("doubt", [{"left": ("a place",)}, {"strained": True}, {"contradiction": "why"}])
def test_two_others_that_stand_out_are_tried_once_each_where_there_is_doubt(tried, doubt):
    vars(tried).update(doubt)
    assert selected() == "tail"
    assert tried.begun == ["walk", "fog"]


def test_none_is_tried_where_enough_was_rendered(tried, monkeypatch):
    tried.left = ("a place",)
    monkeypatch.setattr(TRAIN.work, "enough", True)
    assert selected() == "tail"
    assert tried.begun == []


@pytest.mark.parametrize("name", ["walk", "fog"])
def test_the_likelier_is_kept(tried, name):
    tried.left, tried.likely[name] = ("a place",), 11.0
    assert selected() == name


@pytest.mark.parametrize(("sound", "begun"), [("walk", ["walk"]), ("fog", ["walk", "fog"]), ("tail", [])])
def test_no_more_are_tried_once_there_is_no_doubt(tried, sound, begun):
    """Of what is likelier; another that leaves nothing does not end the search, if it is not."""
    tried.effects, tried.left, tried.sound = 1, ("a place",), (sound,)
    tried.likely |= {"walk": 11.0, "fog": 12.0}
    assert selected() == ("fog" if sound == "fog" else sound)
    assert tried.begun == begun
    tried.begun.clear()
    tried.likely["walk"] = 9.0
    selected()
    assert tried.begun == ([] if sound == "tail" else ["walk", "fog"])


def test_none_is_tried_where_a_cause_outside_leaves_nothing(tried):
    tried.left, tried.alone = ("a place",), True
    assert selected() == "tail"
    assert tried.begun == []


@pytest.mark.parametrize(("likelihood", "kept"), [(-49.0, "walk"), (-51.0, "tail")])
def test_what_is_nearly_as_likely_may_have_another_form(tried, monkeypatch, likelihood, kept):
    """Of what was chosen first, beside what came after; where odds are far it is not tried."""

    def in_another(train, test, forms, rounds):
        (last,) = rounds
        name = last.before.name
        before = SimpleNamespace(**vars(last.before) | {"name": name + " in another form"})
        return [SimpleNamespace(before=before, minor=None)], True

    monkeypatch.setattr(beginnings, "one_in_another_form", in_another)
    tried.left, tried.likely = ("a place",), {"tail": 10.0, "walk": likelihood, "fog": -1e3}
    tried.likely["walk in another form"] = 11.0
    assert selected().split()[0] == kept


def test_what_is_too_little_to_name_counts(tried):
    """Shifted and blurred fits better than a parallax alone, and a parallax and a little blur better still."""
    tried.left, tried.likely["fog"], tried.likely["tail and a little"] = ("a place",), 11.0, 12.0
    tried.minor["tail"] = SimpleNamespace(fit=SimpleNamespace(name="tail and a little"))
    assert selected() == "tail"
    tried.likely["tail and a little"] = 9.0
    assert selected() == "fog"


def test_without_doubt_of_one_no_other_is_tried(tried):
    tried.effects = 1
    assert selected() == "tail"
    assert tried.begun == []


@pytest.mark.parametrize("effects", [2, 3])
@pytest.mark.parametrize(("likelihood", "kept"), [(19.0, "tail"), (21.0, "walk")])
def test_the_first_of_several_may_hold_parts_of_others(tried, effects, likelihood, kept):
    """Without doubt, too: others are tried as the first, and believed at odds that tell."""
    tried.effects = effects
    tried.likely["walk"] = likelihood
    assert selected() == kept
    assert tried.begun == ["walk", "fog"]


@pytest.mark.parametrize(("effects", "others"), [(0, False), (1, True), (2, True), (3, True)])
def test_what_is_left_by_nothing_is_left(tried, effects, others):
    tried.effects, tried.left = effects, ("a place",)
    selected()
    assert bool(tried.begun) == others


RICH, PLAIN = (("passed",), 4), ((), 2)


@pytest.mark.parametrize("left", [(), ("a place",)])
@pytest.mark.parametrize(
    ("effects", "likelihood", "whole", "other", "kept"),
    [
        (2, 21.0, RICH, PLAIN, "pair"),
        (2, 19.0, RICH, PLAIN, "zones"),
        (1, 40.0, RICH, PLAIN, "zones"),
        (2, 21.0, ((), 3), ((), 1), "pair"),  # A shape of three numbers for one of one.
        (2, 21.0, ((), 3), ((), 3), "zones"),
        (2, 21.0, ((), 2), ((), 1), "zones"),
        (2, 21.0, RICH, (("passed",), 3), "zones"),
    ],
)
def test_one_effect_of_many_numbers_may_be_two(tried, monkeypatch, effects, likelihood, whole, other, kept, left):
    """Begun with fewer, before they may become many; believed at odds that tell, whether something is left or not."""
    tried.left = left
    effect = SimpleNamespace(id="surface")

    def form(own=(), many=1):
        return SimpleNamespace(effect=effect, own=own, coordinates=[None] * many)

    def fits(name, forms, candidates):
        before = SimpleNamespace(forms=forms, settings=(), gain=1.0, name=name)
        chosen = candidates[0] if candidates else None
        return [SimpleNamespace(candidates=candidates, chosen=chosen, before=before, minor=None)]

    zones, alike = candidate("surface"), candidate("surface")
    zones.form, alike.form, alike.criterion = form(*whole), form(*other), 1.0
    monkeypatch.setattr(beginnings, "select", lambda *_: fits("zones", (zones.form,), [zones, alike]))

    def begun_with(train, test, forms, first, other, richer=True):
        assert (other, richer) == (alike, False)
        return fits("pair", (form(),) * effects, [])

    monkeypatch.setattr(beginnings, "begun_with", begun_with)
    tried.likely = {"zones": 10.0, "pair": likelihood}
    assert selected() == kept
    monkeypatch.setattr(alike, "stands_out", lambda many: False)
    assert selected() == "zones"


@pytest.mark.parametrize(
    ("own", "likelihood", "kept"), [(True, 21.0, "pair"), (True, 19.0, "zones"), (False, 21.0, "zones")]
)
def test_two_of_other_names_are_tried_for_one_with_a_number_for_each_zone(tried, monkeypatch, own, likelihood, kept):
    """Neither of which begins with such numbers of its own."""
    zones, walk, gains = candidate("falloff"), candidate("walk"), candidate("gain")
    zones.form.own, gains.form.own, begun = ("exponent",) * own, ("factor",), []

    def fits(name, forms, candidates):
        before = SimpleNamespace(forms=forms, settings=(), gain=1.0, name=name)
        return [SimpleNamespace(candidates=candidates, chosen=zones, before=before, minor=None)]

    def begun_with(train, test, forms, first, other, richer=True):
        begun.append((other, richer))
        return fits("pair", (walk.form, walk.form), [])

    monkeypatch.setattr(beginnings, "select", lambda *_: fits("zones", (zones.form,), [zones, walk, gains]))
    monkeypatch.setattr(beginnings, "begun_with", begun_with)
    tried.likely = {"zones": 10.0, "pair": likelihood}
    assert selected() == kept
    assert begun == [(walk, False)] * own


@pytest.mark.parametrize(
    ("deviance", "criterion", "expected", "told"),
    [(5000, 5010, 4, True), (5000, 5010, 300, False), (5950, 5960, 2, False), (5000, 6001, 4, False)],
)
def test_what_shows_in_no_frame_held_out_is_not_judged_by_them(deviance, criterion, expected, told):
    """Much gained at a price that is worth it, of which hardly any is due on frames held out."""
    one = SimpleNamespace(fit=SimpleNamespace(deviance=deviance), criterion=criterion, expected_gain=expected)
    last = SimpleNamespace(before=SimpleNamespace(deviance=6000.0), candidates=[one])
    assert beginnings.unjudged(last) is (one if told else None)

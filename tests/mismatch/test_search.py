"""A search where a cause leaves counts uncertain: rails that pass between one frame and the next."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import poisson

from mismatch import search as module
from mismatch.blocks import halves
from mismatch.economy import economical
from mismatch.explain import explain
from mismatch.fit import fit, fit_nominal
from mismatch.form import all_forms
from mismatch.improved import improved_sensor
from mismatch.leftover import what_is_left
from mismatch.likelier_response import likelier_clock
from mismatch.open_simulation import simulation_of
from mismatch.search import search, searched
from mismatch.trust import as_given
from mismatch.work import MOST_RENDERINGS
from physics.effects import find_effect
from physics.light import direct_light
from physics.nominal import ForwardModel

from .conftest import BACKGROUND, COLUMNS, FRAMES, INTRINSICS, ROWS, depths

LAG_S = 0.02


def rails(times):
    """(F, H, W) metres: rails half-way before the wall, others in each row, that pass at 10 pixels a second."""
    rng = np.random.default_rng(8)
    at = np.arange(COLUMNS) - 10 * np.asarray(times)[:, None, None] + rng.uniform(0, 9, (ROWS, 1))
    passing = np.sin(at * rng.uniform(0.5, 1.1, (ROWS, 1))) > 0
    return np.where(passing, 0.5, depths(1)[0])


@pytest.fixture
def passing(rig):
    """Frames of rails that were recorded a while after the camera saw them."""
    times = np.arange(FRAMES) / 15
    nominal = simulation_of(rig.recording(np.ones((FRAMES, 4, 48)), depth_m=rails(times)), rig.maps)[0]
    light = direct_light(rails(times + LAG_S), INTRINSICS, nominal.light.reflectance, time_s=times)
    late = ForwardModel(light, nominal.footprints, nominal.clock, BACKGROUND).expected(rig.gain)
    counts = np.random.default_rng(3).poisson(late)
    return simulation_of(rig.recording(counts, depth_m=rails(times)), rig.maps)[0]


@pytest.mark.slow
def test_a_lag_is_named_though_nobody_saw_which_edges_had_passed(passing, monkeypatch):
    found = explain(passing).verdict
    assert [effect.id for effect in found.effects] == ["time_lag"]
    assert found.verdict == "explained"
    assert module.UNCERTAIN in found.notes
    lag = found.effects[0].parameters[0]
    # Which edges have passed is chance, and goes on as it began: these rails pass two pixels in three frames.
    assert lag.value == pytest.approx(LAG_S, rel=0.5)
    # All counts trusted, the edges would be what no effect explains.
    monkeypatch.setattr(module, "trusted", lambda *_: None)
    assert explain(passing).verdict.verdict == "unknown"


def test_counts_are_trusted_as_far_as_a_lag_that_is_given_lets_them_be(passing, rig):
    recording = rig.recording(passing.counts, depth_m=rails(np.arange(FRAMES) / 15))
    sensor = simulation_of(recording, rig.maps)[1]
    known = replace(sensor, effects=(find_effect("time_lag").at(lag=LAG_S),))
    simulation = simulation_of(recording, rig.maps, known)[0]
    every, less = (
        sum(place.gain for place in what_is_left(one, fit_nominal(one))) for one in (simulation, as_given(simulation))
    )
    assert less < 0.05 * every
    assert as_given(passing) is passing


def rounds_of(*forms):
    """What a selection came to that found these."""
    return [SimpleNamespace(before=SimpleNamespace(forms=forms))]


@pytest.mark.parametrize(("enough", "kept"), [(True, "first"), (False, "second")])
def test_a_search_anew_that_was_ended_before_it_began_undoes_nothing(passing, monkeypatch, enough, kept):
    """Frames held out one by one find nothing: that tells something only if there was time to look."""
    found = {"first": rounds_of("time_lag"), "second": rounds_of()}
    searches = iter(found.values())
    monkeypatch.setattr(module, "likeliest_selection", lambda *_, last: next(searches))
    monkeypatch.setattr(module, "unjudged", lambda _: SimpleNamespace(fit=None))
    monkeypatch.setattr(module, "_shown_by_both", lambda *_: 0.0)
    monkeypatch.setattr(module, "_uncertain", lambda *_: False)
    monkeypatch.setattr(module, "contested", lambda *_: (SimpleNamespace(forms=()), []))
    monkeypatch.setattr(type(passing.work), "enough", property(lambda _: enough))
    assert search(passing, []).rounds is found[kept]


def test_what_few_frames_show_is_sought_with_some_of_them_on_either_side(passing, monkeypatch):
    """The first four frames that choose are all that show it; every other frame has one of them held out."""
    few = halves(FRAMES)[0][:4]
    assert {frame % 2 for frame in few} == {0, 1}
    rounds, one_side = rounds_of("counter_saturation"), []

    def selection(train, test, _, last):
        one_side.append(not np.isin(few, test.frames).any())
        return rounds

    monkeypatch.setattr(module, "likeliest_selection", selection)
    monkeypatch.setattr(module, "unjudged", lambda _: SimpleNamespace(fit=None) if one_side[-1] else None)
    monkeypatch.setattr(module, "_shown_by_both", lambda *to: min(np.isin(few, part).sum() for part in to[-1]))
    monkeypatch.setattr(module, "_uncertain", lambda *_: False)
    monkeypatch.setattr(module, "contested", lambda *_: (SimpleNamespace(forms=()), []))
    found = search(passing, [])
    assert one_side == [True, False]
    assert found.notes == (module.ONE_BY_ONE,)
    np.testing.assert_array_equal(found.test.frames, np.arange(FRAMES)[1::2])


def test_halves_are_better_that_both_show_what_one_alone_did(drawn):
    simulation = drawn(2)
    nominal = fit_nominal(simulation)
    bad = np.array([4, 5])
    simulation.counts[bad] = 2 * simulation.counts[bad]
    brighter = fit_nominal(simulation.of(bad))
    gained = poisson.logpmf(simulation.counts, simulation.expected(brighter.gain)).sum(axis=(1, 2))
    gained -= poisson.logpmf(simulation.counts, nominal.expected).sum(axis=(1, 2))
    apart, together = (np.arange(0, 24, 2), np.arange(1, 24, 2)), (np.arange(12), np.arange(12, 24))
    found = [module._shown_by_both(simulation, nominal, brighter, parts) for parts in (apart, together)]
    np.testing.assert_allclose(found, [2 * min(gained[p].sum() for p in parts) for parts in (apart, together)])
    assert found[0] > found[1]


@pytest.mark.parametrize("enough", [True, False])
def test_a_search_of_counts_that_are_trusted_less_goes_on_where_it_may_not_begin_anew(passing, monkeypatch, enough):
    going_on, anew = rounds_of("time_lag", "zone_gain"), rounds_of("time_lag")
    owning, before = SimpleNamespace(), rounds_of("time_lag")
    monkeypatch.setattr(module, "likeliest_selection", lambda *_, last: before)
    monkeypatch.setattr(module, "unjudged", lambda _: None)
    monkeypatch.setattr(module, "what_is_left", lambda *_: True)
    monkeypatch.setattr(module, "trusted", lambda simulation, *_: (simulation, owning, before))
    monkeypatch.setattr(module, "onward", lambda train, test, forms, led, now: going_on if now is owning else None)
    monkeypatch.setattr(module, "_beside", lambda train, test, forms, now: anew if now is owning else None)
    monkeypatch.setattr(module, "owns_up", lambda _: True)
    monkeypatch.setattr(module, "contested", lambda *_: (SimpleNamespace(forms=()), []))
    monkeypatch.setattr(type(passing.work), "enough", property(lambda _: enough))
    found = search(passing, [])
    assert found.rounds is (going_on if enough else anew)
    assert found.notes == (module.UNCERTAIN,)


def test_what_an_estimate_held_before_the_cause_was_known_takes_no_name(drawn, rig):
    """Zones thought late, as their maps were beside where they look: told anew they are not."""
    simulation = replace(drawn(4, "footprint_shift", x=40.0, y=-20.0), guessed=True)
    sensor = simulation_of(rig.recording(simulation.counts), rig.maps)[1]
    misled = replace(simulation, clock=likelier_clock(simulation))
    few = {"footprint_shift", "time_zero_offset"}
    forms = [form for form in all_forms({"zone": 4, "bin": 48}) if form.effect.id in few]
    at_once = search(economical(misled), forms).judged
    assert {form.effect.id for form in at_once.forms} == few
    told, found = searched(misled, forms)
    assert [form.effect.id for form in found.judged.forms] == ["footprint_shift"]
    off = [np.abs(one.clock.time_zero_s - simulation.clock.time_zero_s).max() for one in (misled, told)]
    assert off[1] < 0.2 * off[0]
    better = improved_sensor(sensor, SimpleNamespace(explained=found.judged, simulation=told))
    np.testing.assert_array_equal(better.time_zero_s, told.clock.time_zero_s)


@pytest.mark.parametrize(("took", "left"), [(1000.0, 5000.0), (5900.0, 3000.0)])
def test_a_second_search_may_take_what_the_first_left_or_half(drawn, monkeypatch, took, left):
    simulation, begun = replace(drawn(4), guessed=True), []
    form = next(form for form in all_forms({"zone": 4, "bin": 48}) if form.effect.id == "time_zero_offset")
    nominal = fit_nominal(simulation)
    judged = fit(simulation, (form,), np.concatenate([nominal.x, form.at_start()]), 0.0)

    def sought(cheap, forms):
        begun.append(MOST_RENDERINGS - cheap.work.renderings)
        cheap.work.renderings += took
        return SimpleNamespace(judged=judged, train=simulation, notes=())

    monkeypatch.setattr(module, "search", sought)
    monkeypatch.setattr(module, "what_is_left", lambda *_: ("a place",))
    monkeypatch.setattr(module, "_leaving_less", lambda cheap, found, forms: found)
    searched(simulation, [form])
    assert begun == [MOST_RENDERINGS, left]


@pytest.mark.parametrize(
    ("first", "anew", "renderings", "kept"),
    [
        (90.0, 0.0, 100.0, "anew"),
        (90.0, 20.0, 100.0, "anew"),
        (90.0, 40.0, 100.0, "first"),
        (90.0, 0.0, 1e4, "first"),
        # A hundredth of what was explained.
        (10.0, 0.0, 100.0, "first"),
    ],
)
def test_what_blocks_leave_is_sought_by_single_frames(rig, monkeypatch, first, anew, renderings, kept):
    """Sixty frames: as few as the rig's are held out one by one in any case."""
    frames = np.arange(60) % FRAMES
    counts = np.random.default_rng(5).poisson(rig.expected())[frames]
    recording = rig.recording(counts, depth_m=depths()[frames], reflectance=None, timestamp_s=np.arange(60) / 15)
    simulation = simulation_of(recording, rig.maps)[0]
    simulation.work.renderings = renderings
    nominal = fit_nominal(simulation)
    found, other = (
        SimpleNamespace(name=name, left=left, notes=(), train=simulation, judged=replace(nominal, deviance=explained))
        for name, left, explained in (("first", first, nominal.deviance - 1000), ("anew", anew, nominal.deviance))
    )
    monkeypatch.setattr(module, "search", lambda *_, singly=False: other if singly else found)
    monkeypatch.setattr(module, "_left", lambda search: search.left)
    assert module._leaving_less(simulation, found, []).name == kept
    assert module._leaving_less(replace(simulation, guessed=True), found, []).name == "first"
    few = simulation_of(rig.recording(counts[:FRAMES]), rig.maps)[0]
    assert module._leaving_less(few, found, []).name == "first"


@pytest.mark.parametrize(("owning", "asked"), [(True, True), (False, False)])
def test_what_nobody_saw_may_show_in_frames_that_were_held_out(passing, monkeypatch, owning, asked):
    """A lag that frames that choose bear out whole: an edge passed in one that judges."""
    seen = []

    def left(simulation, _):
        return ("a place",) if len(simulation.counts) == FRAMES else ()

    monkeypatch.setattr(module, "likeliest_selection", lambda *_, last: rounds_of("time_lag"))
    monkeypatch.setattr(module, "unjudged", lambda _: None)
    monkeypatch.setattr(module, "what_is_left", left)
    monkeypatch.setattr(module, "_places", lambda every, _: left(every, None))
    monkeypatch.setattr(module, "owns_up", lambda _: owning)
    monkeypatch.setattr(module, "trusted", lambda simulation, *_: seen.append(simulation))
    monkeypatch.setattr(module, "contested", lambda *_: (SimpleNamespace(forms=()), []))
    search(passing, [])
    assert bool(seen) == asked

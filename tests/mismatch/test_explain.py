"""From frames to a verdict: nothing, a cause, a stranger, a zone that is dead."""

import importlib
import json
from dataclasses import replace

import numpy as np
import pytest

from mismatch import work
from mismatch.concluded import LARGE, little
from mismatch.explain import explain
from mismatch.improved import improved_sensor
from mismatch.open_simulation import simulation_of
from mismatch.prove.strangers import travelling_ripple
from mismatch.visibility import FOUND

from .conftest import BACKGROUND
from .test_verdict import FIELDS, fail_on_constant

ONE = {
    "impulse_tail": {"share": 0.15, "tau": 4e-10},
    "time_zero_offset": {"delay": np.array([8e-11, -6e-11, 5e-11, -9e-11])},
    "ambient_pedestal": {"level": 6.0},
    "stray_light": {"share": 0.03},
    "pile_up": {"share": 1.0},
}


def true_value(name, values):
    """Of a parameter by the name that verdicts give it."""
    name, _, place = name.partition("[")
    return values[name][int(place.rstrip("]"))] if place else values[name]


@pytest.mark.usefixtures("every_core")
@pytest.mark.parametrize(
    "name", [pytest.param(one, marks=pytest.mark.slow) if one in ("pile_up", "impulse_tail") else one for one in ONE]
)
def test_one_cause_is_named_and_measured(drawn, name):
    verdict = explain(drawn(5, name, **ONE[name])).verdict
    assert verdict.verdict == "explained"
    (effect,) = verdict.effects
    assert effect.id == name
    for estimate in effect.parameters:
        assert abs(estimate.value - true_value(estimate.name, ONE[name])) < 4 * estimate.sigma
    assert effect.heldout_gain == pytest.approx(effect.expected_gain, rel=0.25)
    assert effect.p_value < 1e-6
    assert sum(look.probability for look in effect.look_alikes) < 0.5
    assert verdict.gap_closed > 0.95
    held = verdict.heldout
    gap = (held.nominal - held.explained) / (held.nominal - held.floor)
    assert verdict.gap_closed == pytest.approx(gap, rel=1e-6)
    assert held.floor <= held.explained < held.nominal
    assert verdict.unexplained == ()
    assert len(verdict.located) == 1
    assert name not in {one.id for one in verdict.not_visible}


def test_a_search_that_was_ended_early_says_so_and_names_nothing_it_has_not_tried(drawn, monkeypatch):
    monkeypatch.setattr(work, "MOST_RENDERINGS", 2)
    found = explain(drawn(5, "impulse_tail", share=0.15, tau=4e-10))
    assert found.verdict.verdict == "unknown"
    assert found.verdict.effects == ()
    assert found.verdict.unexplained
    assert any("the search was ended" in note for note in found.verdict.notes)


@pytest.mark.parametrize("still", ["explained", "unknown"])
def test_a_name_that_falls_short_is_asked_in_its_other_forms(drawn, monkeypatch, still):
    """The first is taken that is in no doubt; where none is, what was found stays."""
    module, asked = importlib.import_module("mismatch.explain"), []
    real = module.concluded

    def in_doubt(*found):
        asked.append(found[4])
        verdict, outside = real(*found)
        return replace(verdict, verdict="unknown" if len(asked) == 1 else still), outside

    monkeypatch.setattr(module, "concluded", in_doubt)
    monkeypatch.setattr(module, "likelier_forms", lambda train, test, judged, forms: [replace(judged), replace(judged)])
    found = explain(drawn(5, "ambient_pedestal", level=6.0))
    assert found.verdict.verdict == still
    assert len(asked) == (2 if still == "explained" else 3)
    assert found.judged is asked[1 if still == "explained" else 0]


@pytest.mark.slow
def test_zones_of_unequal_gain_are_named_and_measured_against_each_other(drawn):
    factor = np.array([1.2, 0.9, 1.1, 0.85])
    (effect,) = explain(drawn(5, "zone_gain", factor=factor)).verdict.effects
    assert effect.id == "zone_gain"
    # A factor common to all zones is the gain of the recording: only their ratios can be measured.
    value, sigma = (np.array([getattr(p, name) for p in effect.parameters]) for name in ("value", "sigma"))
    error = (value / value[0]) / (factor / factor[0]) - 1
    assert (np.abs(error[1:]) < 4 * np.hypot(sigma / value, sigma[0] / value[0])[1:]).all()


def test_nothing_agrees(drawn):
    found = explain(drawn(5), ("A note.",))
    verdict = found.verdict
    assert verdict.verdict == "agrees"
    assert verdict.effects == verdict.located == verdict.unexplained == ()
    assert verdict.gap_closed is None
    assert verdict.next_measurement is None
    assert verdict.heldout.explained == pytest.approx(verdict.heldout.nominal)
    assert verdict.heldout.explained == pytest.approx(1.05, abs=0.12)  # Three standard errors.
    assert set(found.chosen) | set(found.held) == set(range(24))
    held = json.loads(verdict.text(), parse_constant=fail_on_constant)
    assert held.keys() == FIELDS
    assert held["notes"] == ["A note."]


def test_what_is_not_visible_is_said_with_a_strength_that_would_have_been(drawn, rig):
    smallest = {one.id: one for one in explain(drawn(6)).verdict.not_visible}
    assert smallest["ambient_pedestal"].unit == "counts"
    # Information on a level beside a gain that is fitted too, every cell a Poisson number.
    mean, signal = rig.expected(), rig.expected() - BACKGROUND[:, None]
    information = (1 / mean).sum() - (signal / mean).sum() ** 2 / (signal**2 / mean).sum()
    assert smallest["ambient_pedestal"].smallest_visible == pytest.approx(np.sqrt(FOUND / information), rel=0.1)
    there = explain(drawn(7, "ambient_pedestal", level=2 * smallest["ambient_pedestal"].smallest_visible)).verdict
    assert [effect.id for effect in there.effects] == ["ambient_pedestal"]


@pytest.mark.slow
def test_the_improved_sensor_agrees_with_the_recording(drawn, rig):
    found = explain(drawn(8, "impulse_tail", **ONE["impulse_tail"]))
    recording = rig.recording(found.simulation.counts)
    _, sensor, _ = simulation_of(recording, rig.maps)
    better = improved_sensor(sensor, found)
    assert [setting.effect.id for setting in better.effects] == ["impulse_tail"]
    again = explain(simulation_of(recording, rig.maps, better)[0])
    assert again.verdict.verdict == "agrees"


@pytest.mark.slow
def test_a_stranger_is_unknown(rig, simulated):
    mean = travelling_ripple(rig.expected(), 0.1, np.random.default_rng(9))
    verdict = explain(simulated(np.random.default_rng(10).poisson(mean))).verdict
    assert verdict.verdict == "unknown"
    assert verdict.unexplained
    assert json.loads(verdict.text(), parse_constant=fail_on_constant)["verdict"] == "unknown"


@pytest.mark.slow
def test_a_wave_is_never_negligible(rig, simulated):
    """A pedestal that is far stronger takes up none of a wave with another phase in every frame."""
    mean = rig.expected() + 40.0
    frames, zones, bins = np.indices(mean.shape)
    mean = mean + 3.0 * np.sin(2 * np.pi * (bins / 6 + frames * 5 / 24 + zones / 2))
    verdict = explain(simulated(np.random.default_rng(4).poisson(mean))).verdict
    assert "ambient_pedestal" in [effect.id for effect in verdict.effects]
    assert verdict.verdict == "unknown"


@pytest.mark.slow
def test_what_leaves_much_is_no_explanation_however_much_it_takes_up(rig, simulated):
    """Counts that come with a lamp nobody has, out in two frames midway: something flat takes up nearly all else.

    A pedestal, or pulses as long as the window that come again, which leave a gap where one ends.
    """
    mean = rig.expected().copy()
    mean[:, 1] += 60
    mean[11:13, 1] -= 60
    found = explain(simulated(np.random.default_rng(4).poisson(mean)))
    verdict, held = found.verdict, found.verdict.heldout
    assert {effect.id for effect in verdict.effects} <= {"ambient_pedestal", "interference"}
    # All names together: beside the other each of two may gain little.
    assert (held.nominal - held.explained) * mean[found.held].size > 8e4
    assert verdict.verdict == "unknown"


def test_a_dead_zone_is_left_out(rig, simulated):
    counts = np.random.default_rng(11).poisson(rig.expected())
    counts[:, 1] = 0
    assert explain(simulated(counts)).verdict.verdict == "agrees"


@pytest.mark.slow
@pytest.mark.usefixtures("every_core")
def test_the_answer_is_the_same_twice(drawn):
    one, other = (explain(drawn(12, "ambient_pedestal", level=1.0)).verdict.to_json() for _ in range(2))
    one.pop("seconds"), other.pop("seconds")
    assert one == other


@pytest.mark.slow
@pytest.mark.parametrize("strength", [0.02, 0.05])
def test_a_pulse_before_the_pulse_is_a_surface_in_front_or_none(rig, simulated, strength):
    """Counts do not say whether a laser fires in advance or something stands before all that is seen."""
    for seed in range(2):
        rng, expected = np.random.default_rng([13, seed]), rig.expected()
        early = int(rng.integers(5, 10))
        before = np.roll(expected, -early, axis=-1)
        before[..., -early:] = 0
        mean = expected + strength * np.maximum(before - np.median(expected, axis=-1, keepdims=True), 0)
        verdict = explain(simulated(np.random.default_rng([14, seed]).poisson(mean))).verdict
        assert verdict.verdict == "unknown" or [effect.id for effect in verdict.effects] == ["second_surface"]


@pytest.mark.slow
def test_false_alarms_are_rare(drawn):
    wrong = [seed for seed in range(40) if explain(drawn([15, seed])).verdict.verdict != "agrees"]
    assert len(wrong) <= 1, wrong


def test_more_may_be_left_of_what_leaves_things_to_be_guessed_not_of_what_is_beside_it():
    assert little(1000.0, 0.0) == pytest.approx(30)
    assert little(1000.0, 1000.0) == pytest.approx(150)
    # A bounce of 40 beside a pulse of 3000 does not excuse 300 of that.
    assert little(3000.0, 40.0) == pytest.approx(90)
    assert little(1e6, 0.0) == LARGE

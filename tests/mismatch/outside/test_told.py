"""Causes outside the library, told from the names that look like them."""

from types import SimpleNamespace

import numpy as np
import pytest

import mismatch.outside.told as module
from mismatch.blocks import halves
from mismatch.explain import explain
from mismatch.fit import fit, fit_nominal
from mismatch.form import forms_of
from physics.effects import find_effect


def averaged(counts):
    """By a filter that keeps a quarter of what it had."""
    shown = [counts[0]]
    for frame in counts[1:]:
        shown.append(frame + (shown[-1] - frame) / 4)
    return np.stack(shown)


def sloping(counts):
    """A dark level that rises with the square of the bin."""
    return counts + 4 * np.linspace(0, 1, counts.shape[-1]) ** 2


@pytest.mark.parametrize(
    ("made", "words"),
    [
        pytest.param(averaged, "part of what was shown before it", marks=pytest.mark.slow),
        pytest.param(sloping, "counts that no light", marks=pytest.mark.slow),
    ],
)
def test_a_name_that_stands_in_for_a_cause_outside_is_unknown(rig, simulated, made, words):
    verdict = explain(simulated(np.random.default_rng(8).poisson(made(rig.expected())))).verdict
    assert verdict.verdict == "unknown"
    assert any(words in place.sentence for place in verdict.unexplained)


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("time_lag", {"lag": 0.02}),
        pytest.param("bin_width_error", {"error": 0.02}, marks=pytest.mark.slow),
        pytest.param("second_surface", {"passed": 0.1, "spacing": -0.15}, marks=pytest.mark.slow),
        ("impulse_width", {"jitter": 1.5e-10}),
        pytest.param("footprint_shift", {"x": 8.0, "y": -5.0}, marks=pytest.mark.slow),
        pytest.param("ambient_pedestal", {"level": 3.0}, marks=pytest.mark.slow),
    ],
)
def test_a_name_that_is_right_stands(drawn, name, values):
    verdict = explain(drawn(8, name, **values)).verdict
    assert [effect.id for effect in verdict.effects] == [name]
    assert verdict.verdict == "explained"


@pytest.mark.parametrize(
    ("concealed", "alone"),
    [("level", True), pytest.param("both", False, marks=pytest.mark.slow), (None, False)],
)
def test_a_cause_outside_alone_leaves_nothing_where_there_is_no_other(rig, simulated, concealed, alone):
    """A dark level that rises with the bin, for which a flat one was named; not beside a late clock, nor a flat one."""
    late = find_effect("time_zero_offset").at(delay=2e-11)
    mean = rig.expected(*[late] * (concealed == "both"))
    drawn = simulated(np.random.default_rng(8).poisson(sloping(mean) if concealed else mean + 2))
    train, test = (drawn.of(part) for part in halves(len(drawn.counts)))
    form = next(forms_of(find_effect("ambient_pedestal"), {"zone": 4, "bin": mean.shape[-1]}))
    begin = fit_nominal(train).x
    judged = fit(train, (form,), np.concatenate([begin, form.at_start()]), 0.0)
    assert module.told_alone(train, test, judged) == alone


@pytest.mark.parametrize(
    ("worse", "own", "pattern", "told"),
    [(5.0, ("factor",), None, True), (8.0, ("factor",), None, False), (8.0, (), None, True), (8.0, ("edge",), 1, True)],
)
def test_frames_held_out_that_prefer_a_name_with_numbers_of_zones_keep_it(
    drawn, monkeypatch, worse, own, pattern, told
):
    """However likely a cause outside is by both halves."""
    simulation = drawn(8)
    judged, name = SimpleNamespace(pattern=pattern), SimpleNamespace(effect=SimpleNamespace(id="zone_gain"), own=own)
    other = SimpleNamespace(forms=[SimpleNamespace(effect=SimpleNamespace(sentence="x"))])
    monkeypatch.setattr(module, "_lessened", lambda *_: iter([((name,), None)]))
    monkeypatch.setattr(module, "_outside", lambda *_: [other])
    monkeypatch.setattr(module, "evidence", lambda *of: 40.0 * (of[-1] is other))
    monkeypatch.setattr(module, "marginal_deviance", lambda _, fitted: 100.0 + worse * (fitted is other))
    found = module.told_outside(simulation, simulation, simulation, judged, beside=False)
    assert [place.sentence for place in found] == (
        ["zone_gain stands in for something else: it fits better, by 40 in deviance, if x"] if told else []
    )


@pytest.mark.parametrize(
    ("name", "beside", "asked"), [("zone_gain", False, False), ("zone_gain", True, True), ("time_lag", False, True)]
)
def test_what_can_be_mistaken_for_some_names_alone_is_asked_for_beside_these(drawn, monkeypatch, name, beside, asked):
    """It takes long to render, and could not be what others are."""
    forms = []
    monkeypatch.setattr(module, "ranked", lambda train, less, these: (forms.extend(these) or [], 0))
    judged = SimpleNamespace(forms=[SimpleNamespace(effect=SimpleNamespace(id=name))], deviance=0.0)
    assert not module._outside(drawn(8), SimpleNamespace(deviance=100.0), judged, beside)
    assert ("rolling_shutter" in {form.effect.id for form in forms}) == asked
    assert "frame_average" in {form.effect.id for form in forms}

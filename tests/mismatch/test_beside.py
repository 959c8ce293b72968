"""Some of the frames: few, of all times, and with those that fit worst."""

import numpy as np
import pytest

from mismatch import beside
from mismatch.beside import Beside
from mismatch.fit import fit, fit_nominal
from mismatch.form import forms_of
from mismatch.score import score
from physics.effects import find_effect

SIZES = {"zone": 4, "bin": 48}


@pytest.fixture(autouse=True)
def small_ones_too(monkeypatch):
    monkeypatch.setattr(beside, "LARGE", 0)


@pytest.mark.parametrize("sigma", [0.0, 0.02])
def test_a_fit_of_some_frames_is_the_same_model_of_these(drawn, sigma):
    simulation = drawn(2, "ambient_pedestal", level=3.0)
    form = next(f for f in forms_of(find_effect("ambient_pedestal"), SIZES) if f.own)
    whole = fit(simulation, (form,), np.concatenate([fit_nominal(simulation).x, form.at_start()]), sigma)
    chosen = np.array([1, 2, 7, 20])
    some = whole.of(chosen)
    alone = fit(simulation.of(chosen), (form,), whole.x, sigma, most_steps=0)
    np.testing.assert_allclose(some.expected, alone.expected, rtol=1e-12)
    np.testing.assert_allclose(some.columns, alone.columns, rtol=1e-9, atol=1e-9)
    assert some.deviance == pytest.approx(alone.deviance)
    assert some.simulation is whole.of(chosen).simulation


def test_where_nothing_is_amiss_frames_are_taken_evenly(drawn):
    simulation = drawn(2)
    some = Beside(simulation, fit_nominal(simulation)).some
    assert some.frames == 6
    gaps = np.diff(np.concatenate([some.simulation.frames, some.simulation.frames[:1] + 24]))
    assert (gaps <= 6).all()
    assert len(set(gaps)) > 1  # No period that a scene may have, too.


def test_a_frame_that_fits_badly_is_among_them(drawn):
    simulation = drawn(2)
    even = Beside(simulation, fit_nominal(simulation)).some.simulation.frames
    bad = next(i for i in range(24) if i not in even)
    simulation.counts[bad] = simulation.counts[bad][:, ::-1]
    found = Beside(simulation, fit_nominal(simulation)).some.simulation.frames
    assert set(found) == {*even, bad}


def test_few_frames_are_all_asked_and_small_ones(drawn, monkeypatch):
    simulation = drawn(2)
    few = simulation.of(np.arange(15))
    assert Beside(few, fit_nominal(few)).some is None
    monkeypatch.setattr(beside, "LARGE", 1e5)
    assert Beside(simulation, fit_nominal(simulation)).some is None


def test_frames_that_were_asked_for_are_asked_again_where_they_will_do(drawn):
    simulation = drawn(2)
    fitted = fit_nominal(simulation)
    first = Beside(simulation, fitted).some.simulation
    bad = next(i for i in range(24) if i not in first.frames)
    remembered = simulation.remembered
    more = remembered.part(simulation, np.sort(np.append(first.frames, bad)))
    assert Beside(simulation, fitted).some.simulation is more
    np.testing.assert_array_equal(remembered.frames(np.array([0, 22])), [0, 22])


def test_some_frames_tell_of_a_cause_in_proportion(drawn):
    simulation = drawn(3, "impulse_tail", share=0.1, tau=0.6e-9)
    whole = Beside(simulation, fit_nominal(simulation))
    form = next(iter(forms_of(find_effect("impulse_tail"), SIZES)))
    every, some = (score(one.simulation, one.fitted, one.projection, form) for one in (whole, whole.some))
    share = whole.some.frames / whole.frames
    assert some.gain == pytest.approx(share * every.gain, rel=0.5)
    np.testing.assert_allclose(some.amplitude, every.amplitude, rtol=0.3)

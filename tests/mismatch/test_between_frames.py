"""When something happens between frames that chose, against the time at which it was made to."""

from dataclasses import replace

import numpy as np
import pytest

from mismatch.between_frames import placed
from mismatch.fit import fit, fit_nominal
from mismatch.form import forms_of
from physics.effects import find_effect

from .conftest import BINS, ZONES


def form_of(name, free, **given):
    found = next(f for f in forms_of(find_effect(name), {"zone": ZONES, "bin": BINS}) if f.free == free and not f.own)
    return replace(found, start=found.start | given, given=tuple(given))


def chose(simulation):
    """Frames that choose, four of every eight: four of those held out lie in between."""
    return simulation.of(np.flatnonzero(np.arange(len(simulation.counts)) % 8 < 4))


@pytest.mark.parametrize("frame", [4, 5, 6, 7, 8])
def test_what_happens_among_frames_held_out_is_placed_by_them(drawn, frame):
    time_s = np.asarray(drawn(1).light.time_s, float)
    at_s = time_s[frame - 1 : frame + 1].mean()
    simulation = drawn(1, "ambient_pedestal", level=6.0, jump=-5.0, jump_at=at_s)
    train = chose(simulation)
    form = form_of("ambient_pedestal", ("level", "jump"), jump_at=time_s[3:9:5].mean())
    judged = fit(train, (form,), np.concatenate([fit_nominal(train).x, form.at_start()]))
    found = placed(simulation, train, judged)
    assert found.forms[0].start["jump_at"] == pytest.approx(at_s)
    # To those that choose nothing is changed.
    assert found.deviance == judged.deviance
    assert (found.x == judged.x).all()
    again = fit(train, found.forms, found.x, most_steps=0)
    assert again.deviance == pytest.approx(judged.deviance)


def test_what_sets_in_is_placed_likewise(drawn):
    time_s = np.asarray(drawn(1).light.time_s, float)
    simulation = drawn(2, "ambient_pedestal", level=6.0, since=time_s[5:7].mean())
    train = chose(simulation)
    form = form_of("ambient_pedestal", ("level",), since=time_s[3:9:5].mean())
    judged = fit(train, (form,), np.concatenate([fit_nominal(train).x, form.at_start()]))
    assert placed(simulation, train, judged).forms[0].start["since"] == pytest.approx(time_s[5:7].mean())


@pytest.mark.parametrize("given", [{}, {"jump_at": 0.0}, {"jump_at": 1e4}])
def test_what_does_not_happen_between_frames_stays(drawn, given):
    simulation = drawn(3, "ambient_pedestal", level=6.0)
    train = chose(simulation)
    form = form_of("ambient_pedestal", ("level",), **given)
    judged = fit(train, (form,), np.concatenate([fit_nominal(train).x, form.at_start()]))
    assert placed(simulation, train, judged) is judged

"""A mount that is knocked, and one that was always so."""

import numpy as np
import pytest

from mismatch.fit import fit, fit_nominal
from mismatch.form import forms_of
from mismatch.onset import set_in
from mismatch.refined import refined
from physics.effects import find_effect

SIZES = {"zone": 4, "bin": 48}
FORMS = [form for name in ("time_zero_offset", "interference") for form in forms_of(find_effect(name), SIZES)]
LATE = find_effect("time_zero_offset")


@pytest.fixture
def fitted(rig, simulated):
    """Halves of a recording under one delay, and a fit of it."""

    def of(seed, **values):
        simulation = simulated(np.random.default_rng(seed).poisson(rig.expected(LATE.at(**values))))
        train, test = simulation.of(np.arange(0, 24, 2)), simulation.of(np.arange(1, 24, 2))
        form = next(f for f in FORMS if f.effect is LATE and not f.own)
        return train, test, fit(train, (form,), np.concatenate([fit_nominal(train).x, form.at_start()]))

    return of


def test_what_sets_in_is_found_when_and_how_strong(fitted, rig):
    times = np.asarray(fitted(1, delay=1e-10)[0].light.time_s)
    since = float(times[5] + times[6]) / 2
    train, test, always = fitted(2, delay=1e-10, since=since)
    found = set_in(train, test, always)
    (setting,) = found.settings
    assert times[5] < setting.since_s < times[6]
    sigma = np.sqrt(found.covariance[1, 1]) * LATE.parameter("delay").size
    assert abs(setting.values["delay"] - 1e-10) < 4 * sigma
    assert found.forms[0].given == ("since",)
    # Forms that are richer keep it, and it is not sought twice.
    assert set_in(train, test, found) is found
    assert refined(train, test, always, FORMS).settings[0].since_s == setting.since_s


@pytest.mark.parametrize("seed", range(5))
def test_what_was_always_there_did_not_set_in(fitted, seed):
    train, test, always = fitted([3, seed], delay=1e-10)
    assert set_in(train, test, always) is always
    train, test, nothing = fitted([4, seed], delay=0.0)
    assert set_in(train, test, nothing) is nothing

"""A laser that warms up, and one that was always so: what grows is told from the frames, and only where it does."""

import numpy as np
import pytest

from mismatch.fit import fit, fit_nominal
from mismatch.form import forms_of
from mismatch.growing import grown
from mismatch.naming import estimates
from mismatch.refined import refined
from physics.effects import find_effect

FORMS = list(forms_of(find_effect("impulse_tail"), {"zone": 4, "bin": 48}))
SESSION_S = 23 / 15


@pytest.fixture
def fitted(rig, simulated):
    """Halves of a recording with an effect, and a fit of that which does not grow."""

    def of(seed, name="impulse_tail", **values):
        effect = find_effect(name)
        simulation = simulated(np.random.default_rng(seed).poisson(rig.expected(effect.at(**values))))
        train, test = simulation.of(np.arange(0, 24, 2)), simulation.of(np.arange(1, 24, 2))
        form = next(f for f in forms_of(effect, {"zone": 4, "bin": 48}) if not f.own)
        return train, test, fit(train, (form,), np.concatenate([fit_nominal(train).x, form.at_start()]))

    return of


@pytest.mark.parametrize("grows", [1.2, -1.1])
def test_what_grows_is_found_and_by_how_much(fitted, grows):
    train, test, always = fitted([1, int(grows > 0)], share=0.3, tau=5e-10, grows=grows, strong_at=SESSION_S / 2)
    found = grown(train, test, always)
    assert found.deviance < always.deviance - 20
    told = {one.name: one for one in estimates(found, found.forms[0])}
    # By its own reckoning of when it is as strong as is said.
    then = 1 + grows * (told["strong_at"].value - SESSION_S / 2)
    assert abs(told["grows"].value - grows / then) < 4 * told["grows"].sigma
    assert abs(told["share"].value - 0.3 * then) < 4 * told["share"].sigma
    assert grown(train, test, found) is found
    assert "grows" in refined(train, test, always, FORMS).forms[0].free


def test_what_settles_soon_is_found_to(fitted):
    train, test, always = fitted(2, share=0.3, tau=5e-10, grows=6.0, strong_at=1.0, settling=0.1 * SESSION_S)
    (setting,) = grown(train, test, always).settings
    assert setting.values["settling"] == pytest.approx(0.1 * SESSION_S, rel=0.1)
    assert setting.values["grows"] > 0


@pytest.mark.parametrize("seed", range(5))
def test_what_was_always_so_does_not_grow(fitted, seed):
    train, test, always = fitted([3, seed], share=0.3, tau=5e-10)
    assert grown(train, test, always) is always
    train, test, nothing = fitted([4, seed], share=0.0)
    assert grown(train, test, nothing) is nothing


def test_what_grows_by_another_name_is_left_to_that(fitted):
    train, test, always = fitted(5, "time_zero_offset", delay=1e-10, grows=1.2, strong_at=SESSION_S / 2)
    assert grown(train, test, always) is always

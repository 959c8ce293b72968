"""Effects that look where things are in each frame: slopes, promises and gains that are not flattered by the look."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize

from mismatch.descent import Descent
from mismatch.fit import expected_at, fit, fit_nominal
from mismatch.form import forms_of
from mismatch.gained import gained, poisson_scatter
from mismatch.looked import looked
from mismatch.looks import blur, deviance_at, equations, flattery
from mismatch.noise import Nuisances
from physics.effects import find_effect

SIZES = {"zone": 4, "bin": 48}
FORMS = [form for form in forms_of(find_effect("interference"), SIZES) if "roaming" in form.free]
COMMON, BY_ZONE = sorted((form for form in FORMS if "longer" not in form.free), key=lambda f: len(f.own))
LONGER = next(form for form in FORMS if "longer" in form.free and not form.own)
VALUES = {"roaming": 60.0, "present": 0.7}


@pytest.fixture(scope="module")
def disturbed(drawn_with_pulses):
    """Frames of which most hold a pulse somewhere."""
    return drawn_with_pulses(4)


@pytest.fixture(scope="module")
def drawn_with_pulses(rig, simulated):
    """Such frames, one recording for each seed."""
    return lambda seed: _disturbed(rig, simulated, seed)


def _disturbed(rig, simulated, seed):
    rng = np.random.default_rng(seed)
    effect = find_effect("interference")
    bare = simulated(rig.expected())
    gain = fit_nominal(bare).gain
    setting = effect.at(**VALUES)
    nothing = replace(bare.without(gain, (setting,), setting), recorded=None)
    mean = effect.at_random(setting.values, nothing, rng)
    return simulated(rng.poisson(mean))


@pytest.mark.parametrize("form", [COMMON, BY_ZONE, LONGER], ids=["common", "by zone", "longer"])
def test_slopes_are_those_of_the_deviance(form, disturbed):
    nuisances = Nuisances(disturbed, 0.0)
    x = np.concatenate([fit_nominal(disturbed).x, form.beginning({"roaming": 40.0, "present": 0.6}).at_start()])
    here = expected_at(disturbed, (form,), x)
    score, information = equations(nuisances, (form,), x, here, np.ones((here.size, len(x))))
    for i in range(1, len(x)):
        ends = [x.copy(), x.copy()]
        ends[0][i] -= 1e-4
        ends[1][i] += 1e-4
        low, high = (deviance_at(nuisances, (form,), end, expected_at(disturbed, (form,), end)) for end in ends)
        # The log-likelihood is less half the deviance, but for the frames' own brightness, which the look takes out:
        # within a fifth of what the score varies by from recording to recording.
        spread = np.sqrt(information[i, i])
        assert score[i] == pytest.approx(-(high - low) / 4e-4, rel=0.02, abs=0.2 * spread)
    assert (np.linalg.eigvalsh(information[1:, 1:]) > -1e-6).all()


def test_a_fit_finds_how_strong_and_how_often(disturbed):
    begun = COMMON.beginning({"roaming": 20.0, "present": 0.5})
    found = fit(disturbed, (begun,), np.concatenate([fit_nominal(disturbed).x, begun.at_start()]))
    for i, name in enumerate(("roaming", "present")):
        value, unit = found.settings[0].values[name], {"roaming": 100.0, "present": 0.7}[name]
        assert abs(value - VALUES[name]) < 4 * np.sqrt(found.covariance[i + 1, i + 1]) * unit
    assert flattery(disturbed, found.gain, found.settings) > 0
    assert blur(disturbed, found.gain, found.settings) > 0


def test_only_pulses_that_roam_look():
    forms = list(forms_of(find_effect("interference"), SIZES))
    assert {form.free for form in forms if form.looks} == {("roaming", "present"), ("roaming", "present", "longer")}
    assert not next(forms_of(find_effect("impulse_tail"), SIZES)).looks


def test_where_there_is_nothing_nothing_is_promised(drawn):
    for seed in range(3):
        simulation = drawn(seed)
        promised = looked(simulation, fit_nominal(simulation), COMMON.beginning({"roaming": 10.0, "present": 0.5}))
        assert promised.log_p > np.log(1e-3)
        assert promised.information == 0


def test_held_out_frames_gain_what_they_should_and_scatter_as_they_say(drawn_with_pulses):
    """Of twenty recordings; how much a pulse shows depends on where it is, and whether it is there is chance."""
    off, ratios = [], []
    for seed in range(20):
        recorded = drawn_with_pulses(100 + seed)
        train, test = recorded.of(np.arange(0, 24, 2)), recorded.of(np.arange(1, 24, 2))
        begun, nominal = COMMON.beginning({"roaming": 50.0, "present": 0.7}), fit_nominal(train)
        won = gained(test, nominal, fit(train, (begun,), np.concatenate([nominal.x, begun.at_start()])))
        off.append((won.observed - won.expected) / (np.sqrt(2) * won.scatter))
        ratios.append(won.observed / won.expected)
        assert 5 < won.z <= np.sqrt(won.observed)
        assert won.scatter > 1.2 * poisson_scatter(won.expected)
    assert np.median(ratios) == pytest.approx(1, abs=0.15)
    assert 0.6 < np.std(off) < 1.4


def test_a_pulse_that_is_longer_is_fitted_from_far_off(rig, simulated):
    """From half a nanosecond, as all are. As a minimiser without derivatives finds it (Nelder and Mead 1965)."""
    rng = np.random.default_rng(2)
    effect = find_effect("interference")
    bare = simulated(rig.expected())
    gain = fit_nominal(bare).gain
    setting = effect.at(roaming=400.0, present=0.4, longer=2e-10)
    nothing = replace(bare.without(gain, (setting,), setting), recorded=None)
    simulation = simulated(rng.poisson(effect.at_random(setting.values, nothing, rng)))
    x = fit_nominal(simulation).x
    far = Descent(simulation, (LONGER,), np.concatenate([x, LONGER.beginning({"roaming": 250.0}).at_start()]), 0.0)
    nuisances = Nuisances(simulation, 0.0)

    def at(y):
        y = np.clip(y, far.low, far.high)
        return deviance_at(nuisances, (LONGER,), y, expected_at(simulation, (LONGER,), y))

    true = np.concatenate([x, LONGER.beginning({name: setting.values[name] for name in LONGER.free}).at_start()])
    # The brightness of frames, which the look takes out, is left to slopes: they end a little off.
    assert far.run().deviance < 1.002 * minimize(at, true, method="Nelder-Mead", options={"maxfev": 400}).fun

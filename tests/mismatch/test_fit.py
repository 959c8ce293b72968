"""The fit against scipy's minimiser, and its errors against repeated draws."""

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.stats import poisson

from mismatch import pattern
from mismatch.fit import expected_at, fit, fit_nominal, on_others
from mismatch.form import forms_of
from mismatch.noise import Nuisances
from mismatch.poisson import deviance
from mismatch.selection import coordinates
from physics.effects import find_effect
from recordings.refusal import Refusal

from .conftest import BACKGROUND


def form_of(name, own=False):
    return next(f for f in forms_of(find_effect(name), {"zone": 4, "bin": 48, "edge": 47}) if bool(f.own) == own)


def fitted_with(simulation, name, own=False):
    form, nominal = form_of(name, own), fit_nominal(simulation)
    return fit(simulation, (form,), np.concatenate([nominal.x, form.at_start()]))


def minus_log_likelihood(counts, signal, pedestal):
    """Of gain and pedestal, each cell one Poisson number."""

    def loss(x):
        mean = np.exp(x[0]) * signal + BACKGROUND[:, None] + (x[1] if pedestal else 0)
        return -poisson.logpmf(counts, mean).sum()

    return loss


def test_gain_and_pedestal_are_those_of_a_general_minimiser(drawn, rig):
    simulation = drawn(1, "ambient_pedestal", level=2.0)
    fitted = fitted_with(simulation, "ambient_pedestal")
    signal = (rig.expected() - BACKGROUND[:, None]) / rig.gain
    loss = minus_log_likelihood(simulation.counts, signal, True)
    oracle = minimize(loss, [np.log(rig.gain), 1.0], method="Nelder-Mead", options={"xatol": 1e-6, "fatol": 1e-6})
    sigma = np.sqrt(np.diag(fitted.covariance))
    assert abs(fitted.x[0] - oracle.x[0]) < 0.05 * sigma[0]
    assert abs(fitted.settings[0].values["level"] - oracle.x[1]) < 0.05 * sigma[1] * 10.0
    saturated = -2 * poisson.logpmf(simulation.counts, np.maximum(simulation.counts, 1e-300)).sum()
    assert fitted.deviance == pytest.approx(2 * oracle.fun - saturated, abs=0.05)


def test_its_errors_are_the_curvature_of_the_likelihood(drawn, rig):
    simulation = drawn(2, "ambient_pedestal", level=2.0)
    fitted = fitted_with(simulation, "ambient_pedestal")
    loss = minus_log_likelihood(simulation.counts, (rig.expected() - BACKGROUND[:, None]) / rig.gain, True)
    best = np.array([fitted.x[0], 10 * fitted.x[1]])
    steps = np.diag([1e-4, 1e-2])
    hessian = [[
        (loss(best + a + b) - loss(best + a - b) - loss(best - a + b) + loss(best - a - b)) / (4 * a.sum() * b.sum())
        for b in steps] for a in steps]  # fmt: skip
    scale = np.array([1.0, 10.0])
    np.testing.assert_allclose(fitted.covariance * np.outer(scale, scale), np.linalg.inv(hessian), rtol=0.1, atol=1e-7)


@pytest.mark.parametrize("away", [-1.5, 0.8, 2.0])
@pytest.mark.parametrize("held", [1, 2])
@pytest.mark.parametrize("worked", [False, True])
def test_others_are_at_their_best_beside_one_that_is_held(drawn, held, away, worked, monkeypatch):
    """Against a general minimiser. Where enough was rendered, by steps of one rendering alone."""
    simulation = drawn(8, "impulse_tail", share=0.15, tau=4e-10)
    fitted = fitted_with(simulation, "impulse_tail")
    nuisances = Nuisances(simulation, 0.0)
    _, information = nuisances.normal_equations(fitted.expected, fitted.columns)
    error = np.sqrt(np.linalg.inv(information)[held, held])
    x = fitted.x.copy()
    x[held] += away * error
    free = np.arange(3) != held

    def loss(values):
        there = x.copy()
        there[free] = values
        return nuisances.deviance(expected_at(simulation, fitted.forms, there))

    oracle = minimize(loss, x[free], method="Nelder-Mead", options={"xatol": 1e-5, "fatol": 1e-4}).fun
    if worked:
        monkeypatch.setattr(simulation.work, "renderings", 10**6)
    found = fitted._deviance_near(nuisances, information, x, held)
    assert found - fitted.deviance == pytest.approx(oracle - fitted.deviance, rel=0.03, abs=0.02)


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("impulse_tail", {"share": 0.15, "tau": 4e-10}),
        ("time_zero_offset", {"delay": np.array([8e-11, -6e-11, 5e-11, -9e-11])}),
        ("pile_up", {"share": 0.7}),
        ("stray_light", {"share": 0.03}),
    ],
)
def test_what_was_put_in_comes_out(drawn, name, values):
    own = any(np.ndim(value) for value in values.values())
    fitted = fitted_with(drawn(3, name, **values), name, own)
    x = coordinates(fitted, fitted.forms[0])
    truth = fitted.forms[0].coordinates_of(find_effect(name).at(**values))
    assert (np.abs(x - truth) < 4 * np.sqrt(np.diag(fitted.covariance)[1:])).all()


def test_a_strength_that_data_push_below_nothing_stays_at_nothing(simulated, rig):
    counts = np.random.default_rng(4).poisson(np.maximum(rig.expected() - 1.0, 0))
    assert fitted_with(simulated(counts), "ambient_pedestal").settings[0].values["level"] == 0


def test_frames_that_were_not_fitted_are_as_well_described(drawn):
    simulation = drawn(5)
    chosen, held = np.arange(12), np.arange(12, 24)
    fitted = fit_nominal(simulation.of(chosen))
    expected, deviance = on_others(simulation.of(held), fitted)
    assert expected.shape == (12, 4, 48)
    assert deviance / expected.size == pytest.approx(
        fitted.deviance / expected.size, abs=6 * np.sqrt(4 / expected.size)
    )


def test_a_scene_that_returns_nothing_is_refused(rig):
    from mismatch.open_simulation import simulation_of

    dark = rig.recording(np.ones((24, 4, 48)), reflectance=np.zeros((24, 10, 17)))
    with pytest.raises(Refusal, match="no zone sees any light"):
        fit_nominal(simulation_of(dark, rig.maps)[0])


@pytest.mark.slow
def test_two_of_three_intervals_of_one_sigma_hold_the_truth(drawn):
    pulls = []
    for seed in range(60):
        fitted = fitted_with(drawn([6, seed], "impulse_tail", share=0.1, tau=4e-10), "impulse_tail")
        truth = fitted.forms[0].coordinates_of(find_effect("impulse_tail").at(share=0.1, tau=4e-10))
        pulls.append((fitted.x[1:] - truth) / np.sqrt(np.diag(fitted.covariance)[1:]))
    pulls = np.array(pulls)
    # 0.68 within three standard deviations of a binomial of 60.
    held = (np.abs(pulls) < 1).mean(axis=0)
    assert ((held > 0.50) & (held < 0.86)).all()
    assert (np.abs(pulls.mean(axis=0)) < 3 / np.sqrt(60)).all()
    assert (pulls.std(axis=0) > 0.7).all()
    assert (pulls.std(axis=0) < 1.3).all()


@pytest.mark.parametrize("astray", [0.0, 1.0])
def test_numbers_that_are_drawn_come_to_the_best_of_likelihood_and_distribution(drawn, monkeypatch, astray):
    """Also where counts do not go as straight as the curvature says; a general minimiser is the oracle."""
    simulation = drawn(3, "bin_nonlinearity", width=np.random.default_rng(1).normal(0, 0.05, 48))
    form = next(f for f in forms_of(find_effect("bin_nonlinearity"), {"zone": 4, "bin": 48}) if f.free == ("width",))
    straight = pattern.shrunk

    def led_astray(*of):
        x, found = straight(*of)
        there = x + astray * np.eye(len(x))[0]
        return there, found

    monkeypatch.setattr("mismatch.fit.shrunk", led_astray)
    found = fit(simulation, (form,), np.concatenate([fit_nominal(simulation).x, form.at_start()]))

    def unlikely(x):
        return deviance(simulation.counts, expected_at(simulation, (form,), x)).sum() + found.pattern.unlikely(x)

    best = minimize(unlikely, found.x, method="Powell", options={"maxfev": 20_000})
    assert unlikely(found.x) < best.fun + 0.5
    assert found.deviance == pytest.approx(deviance(simulation.counts, found.expected).sum())

"""Gain that fluctuates from frame to frame."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize, minimize_scalar
from scipy.sparse import csc_array
from scipy.stats import norm, poisson

from mismatch.fit import fit, fit_nominal
from mismatch.form import forms_of
from mismatch.gained import gained
from mismatch.noise import Nuisances
from physics.effects import find_effect

from .conftest import BACKGROUND, FRAMES


def test_gains_and_deviance_are_those_of_the_penalised_likelihood(rig, fluctuating):
    sigma = 0.03
    factors = 1 + sigma * np.random.default_rng(5).normal(size=FRAMES)
    simulation = fluctuating(6, factors)
    expected = rig.expected()
    nuisances = Nuisances(simulation, sigma)
    u = nuisances.best(expected)
    for frame in (0, 7, 23):
        signal, counts = expected[frame] - BACKGROUND[:, None], simulation.counts[frame]

        def loss(x, signal=signal, counts=counts):
            return -poisson.logpmf(counts, x * signal + signal + BACKGROUND[:, None]).sum() - norm.logpdf(
                x[0], 0, sigma
            )

        best = minimize(lambda x, loss=loss: loss(np.atleast_1d(x)), [0.0], method="Nelder-Mead").x[0]
        assert u[frame] == pytest.approx(best, abs=2e-5)
    plain = Nuisances(simulation, 0.0)
    assert nuisances.deviance(expected) < plain.deviance(expected)
    np.testing.assert_array_equal(plain.applied(expected), expected)
    np.testing.assert_array_equal(plain.best(expected), 0)


@pytest.mark.parametrize("kind", [np.asarray, csc_array])
@pytest.mark.parametrize("sigma", [0.0, 0.04])
def test_information_is_that_with_a_parameter_for_every_frame(rig, fluctuating, sigma, kind):
    simulation = fluctuating(7, np.ones(FRAMES))
    expected = rig.expected()
    columns = np.random.default_rng(8).normal(size=(expected.size, 3)) * np.sqrt(expected).reshape(-1, 1)
    _, information = Nuisances(simulation, sigma).normal_equations(expected, kind(columns))
    frames = np.zeros((expected.size, FRAMES))
    for i, signal in enumerate(expected - BACKGROUND[:, None]):
        frames.reshape(FRAMES, -1, FRAMES)[i, :, i] = signal.ravel()
    whole = np.hstack([columns, frames]) if sigma else columns
    matrix = whole.T @ (whole / expected.reshape(-1, 1))
    if sigma:
        matrix[3:, 3:] += np.eye(FRAMES) / sigma**2
        matrix = matrix[:3, :3] - matrix[:3, 3:] @ np.linalg.solve(matrix[3:, 3:], matrix[3:, :3])
    np.testing.assert_allclose(information, matrix, rtol=1e-6, atol=1e-6 * np.abs(matrix).max())


@pytest.mark.parametrize("kind", [np.asarray, csc_array])
@pytest.mark.parametrize("sigma", [0.0, 0.04])
def test_the_score_is_the_slope_of_the_penalised_likelihood(rig, fluctuating, sigma, kind):
    """By differences, each frame's gain at its best as scipy finds it, of a model that is off."""
    simulation = fluctuating(7, 1 + sigma * np.random.default_rng(5).normal(size=FRAMES))
    expected = 1.05 * rig.expected()
    columns = np.random.default_rng(8).normal(size=(expected.size, 3)) * 0.1 * expected.reshape(-1, 1)

    def log_likelihood(step):
        mean, total = expected + (columns @ step).reshape(expected.shape), 0.0
        for counts, every in zip(simulation.counts, mean, strict=True):
            signal = every - BACKGROUND[:, None]

            def of(u, counts=counts, every=every, signal=signal):
                gone = norm.logpdf(u, 0, sigma) if sigma else 0.0
                return -poisson.logpmf(counts, every + u * signal).sum() - gone

            total -= minimize_scalar(of, bounds=(-0.5, 0.5), method="bounded").fun if sigma else of(0.0)
        return total

    score, _ = Nuisances(simulation, sigma).normal_equations(expected, kind(columns))
    slopes = [(log_likelihood(h) - log_likelihood(-h)) / 2e-3 for h in 1e-3 * np.eye(3)]
    np.testing.assert_allclose(score, slopes, rtol=1e-4, atol=1e-4 * np.abs(slopes).max())


def test_a_cell_that_is_empty_as_it_should_be_has_no_slope(rig, fluctuating):
    """Deviance does not change where fewer counts are expected than matter; where some came all the same it does."""
    simulation = fluctuating(7, np.ones(FRAMES))
    expected, dark = rig.expected(), np.zeros((FRAMES, 4, 48), bool)
    dark[:, :, :2] = True
    simulation = replace(simulation, counts=np.where(dark, 0.0, simulation.counts))
    expected = np.where(dark, 1e-5, expected)
    for counts, empty in ((simulation.counts, True), (np.where(dark, 1.0, simulation.counts), False)):
        nuisances = Nuisances(replace(simulation, counts=counts), 0.0)
        score, _ = nuisances.normal_equations(expected, np.where(dark, 1e-3, 0.0).reshape(-1, 1))
        assert (score[0] == 0) == empty


@pytest.mark.parametrize("sigma", [0.0, 0.003, 0.05])
def test_changes_are_multiplied_by_the_inverse_covariance_of_photons_and_gains(drawn, sigma):
    """Written out frame by frame; what goes with a frame's gain counts for as much less as that fluctuates."""
    simulation = drawn(4)
    expected = fit_nominal(simulation).expected
    nuisances = Nuisances(simulation, sigma)
    rng = np.random.default_rng(5)
    signal = expected - BACKGROUND[:, None]
    one, other = (rng.normal(size=expected.shape) + rng.normal(size=(FRAMES, 1, 1)) * signal / 50 for _ in range(2))
    closed = 0.0
    for f in range(FRAMES):
        mean, s = nuisances.applied(expected)[f].ravel(), signal[f].ravel()
        inverse = np.linalg.inv(np.diag(mean) + sigma**2 * np.outer(s, s))
        closed += one[f].ravel() @ inverse @ other[f].ravel()
    assert nuisances.product(expected, one, other) == pytest.approx(closed, rel=1e-6)


def test_a_drift_stands_out_of_gain_that_fluctuates(fluctuating):
    """Its z on frames held out scatters by 1 about the root of what it should gain there."""
    sigma, away = 0.01, []
    drift = 1 + 0.05 * np.linspace(-1, 1, FRAMES)
    for seed in range(20):
        rng = np.random.default_rng([9, seed])
        simulation = fluctuating(seed, drift * (1 + sigma * rng.normal(size=FRAMES)))
        test = simulation.of(np.arange(1, FRAMES, 2))
        (form, *_) = forms_of(find_effect("gain_drift"), {"zone": 4, "bin": 48})
        less = fit_nominal(simulation, sigma)
        more = fit(simulation, (form,), np.concatenate([less.x, form.at_start()]), sigma)
        found = gained(test, less, more)
        away.append(found.z - np.sqrt(found.expected))
    assert found.expected > 5
    assert abs(np.mean(away)) < 1
    assert 0.3 < np.std(away) < 2


@pytest.mark.parametrize("times", [1.0, 1.5, 3.0])
def test_what_the_clock_said_elsewhere_takes_no_more_than_there_is(drawn, rig, times):
    """A gain that an estimated clock nearly says: its information there, times too much, would make a hill a valley."""
    simulation = drawn(2)
    expected = simulation.expected(rig.gain)
    ramp = np.linspace(-1, 1, expected.shape[2])
    simulation = replace(simulation, loose=np.stack([0.3 * expected, 0.1 * ramp * expected]))
    nuisances, columns = Nuisances(simulation, 0.0), np.stack([expected.ravel(), (ramp * expected).ravel()], axis=1)
    score, exact = nuisances.normal_equations(expected, columns)
    nuisances._near = times * nuisances._inverse(nuisances.settled(expected))
    found, nearly = nuisances.normal_equations(expected, columns, nearly=True)
    np.testing.assert_allclose(nearly, exact, rtol=1e-6)
    np.testing.assert_allclose(found, score, rtol=1e-6)
    assert np.linalg.eigvalsh(nearly).min() > 0

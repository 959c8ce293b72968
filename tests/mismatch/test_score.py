"""Score tests against the likelihood ratio itself, and the projection against columns written out."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.special import gammaln
from scipy.stats import poisson

from mismatch.fit import fit_nominal
from mismatch.form import forms_of
from mismatch.projection import Projection
from mismatch.score import log_chance, score, start_of
from physics.effects import find_effect

from .conftest import BACKGROUND, BINS, FRAMES, ZONES

SIZES = {"zone": ZONES, "bin": BINS, "edge": BINS - 1}


def form_of(name, own=False):
    return next(f for f in forms_of(find_effect(name), SIZES) if bool(f.own) == own)


def scored(simulation, form):
    nominal = fit_nominal(simulation)
    return score(simulation, nominal, Projection(simulation, nominal), form)


@pytest.mark.parametrize("seed", range(3))
def test_the_gain_promised_is_that_of_the_likelihood_ratio(drawn, rig, seed):
    simulation = drawn([1, seed], "ambient_pedestal", level=0.3)
    signal = (rig.expected() - BACKGROUND[:, None]) / rig.gain

    def loss(x):
        mean = np.exp(x[0]) * signal + BACKGROUND[:, None] + (x[1] if len(x) > 1 else 0)
        return -poisson.logpmf(simulation.counts, mean).sum()

    begin, tight = np.log(rig.gain), {"xatol": 1e-7, "fatol": 1e-6}
    without = minimize(loss, [begin], method="Nelder-Mead", options=tight)
    there = minimize(loss, [begin, 0.2], method="Nelder-Mead", options=tight)
    found = scored(simulation, form_of("ambient_pedestal"))
    assert found.dof == 1
    assert found.gain == pytest.approx(2 * (without.fun - there.fun), rel=0.1)
    assert start_of(found.form, found.amplitude)[0] * 10 == pytest.approx(there.x[1], rel=0.1)


def test_by_chance_a_score_gains_one_unit_for_each_number_it_takes(drawn):
    # A delay may be of either sign, so that nothing is cut off at a bound.
    gains = [scored(drawn([2, seed]), form_of("time_zero_offset", own=True)).gain for seed in range(30)]
    # Chi-square of 4: mean 4, standard deviation of the mean of 30 is 0.52.
    assert np.mean(gains) == pytest.approx(4, abs=4 * np.sqrt(8 / 30))


@pytest.mark.parametrize("sigma", [0.0, 0.03])
@pytest.mark.parametrize("axis", ["zone", "bin"])
def test_divided_columns_are_as_if_they_were_written_out(drawn, axis, sigma):
    simulation = drawn(3)
    fitted = fit_nominal(simulation, sigma)
    projection = Projection(simulation, fitted)
    change = np.random.default_rng(4).normal(size=fitted.expected.shape) * np.sqrt(fitted.expected)
    many = SIZES[axis]
    dense = np.zeros((*change.shape, many))
    for i in range(many):
        own = (slice(None), i) if axis == "zone" else (slice(None), slice(None), i)
        dense[(*own, ..., i)] = change[own]
    white = projection.whitened(dense.reshape(-1, many))
    information, promised, before = projection.divided(change[None], axis)
    np.testing.assert_allclose(information, white.T @ white, rtol=1e-9, atol=1e-6)
    np.testing.assert_allclose(promised, white.T @ projection.residual, rtol=1e-9, atol=1e-6)
    weighted = (dense**2 / fitted.expected[..., None]).reshape(-1, many).sum(axis=0)
    np.testing.assert_allclose(before, weighted, rtol=0.02)


@pytest.mark.parametrize("sigma", [0.0, 0.03])
def test_projection_is_the_information_left_when_gain_and_frames_are_fitted_too(drawn, sigma):
    simulation = drawn(5)
    fitted = fit_nominal(simulation, sigma)
    projection = Projection(simulation, fitted)
    rng, cells = np.random.default_rng(6), fitted.expected.size
    tried = rng.normal(size=(cells, 2)) * np.sqrt(fitted.expected).reshape(-1, 1)
    frames = np.zeros((cells, FRAMES))
    for i, signal in enumerate(fitted.expected - BACKGROUND[:, None]):
        frames.reshape(FRAMES, -1, FRAMES)[i, :, i] = signal.ravel()
    others = np.hstack([fitted.columns, frames]) if sigma else fitted.columns
    weight = projection.root[:, None] ** 2
    inner = others.T @ (others * weight)
    if sigma:
        inner[1:, 1:] += np.eye(FRAMES) / sigma**2
    mixed = tried.T @ (others * weight)
    left = tried.T @ (tried * weight) - mixed @ np.linalg.solve(inner, mixed.T)
    white = projection.whitened(tried)
    np.testing.assert_allclose(white.T @ white, left, rtol=1e-6, atol=1e-3)


@pytest.mark.parametrize("sigma", [0.0, 0.004, 0.03])
def test_what_is_promised_is_the_slope_of_a_likelihood_in_which_frames_have_gains(drawn, sigma):
    """Of normal counts whose covariance is the photons' and that of the frames' gains, written out frame by frame."""
    simulation = drawn(5)
    factor = 1 + sigma * np.random.default_rng(2).normal(size=(FRAMES, 1, 1))
    counts = np.random.default_rng(3).poisson(factor * simulation.counts).astype(float)
    simulation = replace(simulation, counts=counts)
    fitted = fit_nominal(simulation, sigma)
    projection = Projection(simulation, fitted)
    signal = (fitted.expected - BACKGROUND[:, None]).reshape(FRAMES, -1)
    # A drift: of the frames' gains themselves.
    drift = (np.linspace(-1, 1, FRAMES)[:, None] * signal).ravel()
    mean = 1 / projection.root.reshape(FRAMES, -1) ** 2
    away = (counts - fitted.expected).reshape(FRAMES, -1)
    inverse = [np.linalg.inv(np.diag(m) + sigma**2 * np.outer(s, s)) for m, s in zip(mean, signal, strict=True)]

    def product(one, other):
        parts = zip(one.reshape(FRAMES, -1), inverse, other.reshape(FRAMES, -1), strict=True)
        return sum(a @ v @ b for a, v, b in parts)

    gain = fitted.columns[:, 0]
    drift = drift - gain * product(drift, gain) / product(gain, gain)
    white = projection.whitened(drift[:, None])[:, 0]
    assert white @ projection.residual == pytest.approx(product(drift, away), rel=1e-6)
    assert white @ white == pytest.approx(product(drift, drift), rel=1e-6)


def test_what_is_fitted_already_promises_nothing(drawn):
    # One factor for all zones is the gain itself.
    alike = replace(form_of("zone_gain", own=True), own=())
    found = scored(drawn(7), alike)
    assert found is None or found.gain < 1e-3


def test_amplitudes_stay_within_the_bounds_of_their_parameters(simulated, rig):
    below = simulated(np.random.default_rng(8).poisson(np.maximum(rig.expected() - 1.0, 0)))
    found = scored(below, form_of("ambient_pedestal"))
    assert found.amplitude == pytest.approx([0.0])
    assert found.gain == 0


def test_chances_too_small_for_a_number_still_have_an_order():
    for dof in (1, 2, 9):
        edge = np.array([900.0, 1200.0])
        series = (dof / 2 - 1) * np.log(edge / 2) - edge / 2 - np.array([gammaln(dof / 2)] * 2)
        np.testing.assert_allclose(series, [log_chance(gain, dof) for gain in edge], rtol=0.01)
        assert -np.inf < log_chance(5000.0, dof) < log_chance(3000.0, dof) < log_chance(1200.0, dof)


@pytest.mark.parametrize(("late", "kept"), [(83.0, True), (4.5, False)])
def test_an_edge_that_the_data_gave_is_not_moved_by_the_score(late, kept):
    """What a score multiplies is the loss, which does not go with the edge's place."""
    form = next(f for f in forms_of(find_effect("window_clipping"), SIZES) if f.free == ("late",) and not f.own)
    form = replace(form, start=form.start | {"late": late})
    found = form.setting(start_of(form, np.array([0.3]))).values["late"]
    assert found == pytest.approx(late if kept else 0.3 * late)

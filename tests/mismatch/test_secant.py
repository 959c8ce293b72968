"""Curvature learnt from steps against that of functions which are known, and fits that need it."""

import itertools

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.linalg import eigvalsh
from scipy.optimize import minimize

from mismatch.derivatives import expected_at
from mismatch.descent import Descent
from mismatch.form import forms_of
from mismatch.looks import deviance_at
from mismatch.score import start_of
from mismatch.secant import LEAST_PART, MANY, PAIRS, Secant
from physics.effects import find_effect

from .conftest import BINS, ZONES

numbers = st.floats(-3, 3).map(lambda x: round(x, 3))


def positive(rng, n):
    """A positive (N, N) matrix."""
    root = rng.normal(size=(n, n))
    return root @ root.T + 0.1 * np.eye(n)


@given(arrays(float, (PAIRS + 2, 4), elements=numbers), arrays(float, (PAIRS + 2, 4), elements=numbers))
def test_what_is_learnt_stays_positive(steps, lost):
    """Whatever the score did, as where a fit is far from convex."""
    secant = Secant()
    for step, change in zip(steps, lost, strict=True):
        secant.learn(step, change)
    found = secant.corrected(np.diag([1.0, 2, 3, 4]))
    assert np.allclose(found, found.T, rtol=1e-9, atol=1e-9 * np.abs(found).max())
    assert eigvalsh(found).min() > -1e-9 * np.abs(found).max()


@given(st.integers(0, 1000), st.integers(2, 8))
def test_the_last_step_is_borne_out(seed, n):
    """The score falls along it as it did (the secant equation)."""
    rng = np.random.default_rng(seed)
    curvature, step = positive(rng, n), rng.normal(size=n)
    lost = rng.uniform(1.5 * LEAST_PART, 5) * curvature @ step
    secant = Secant()
    secant.learn(rng.normal(size=n), rng.normal(size=n))
    secant.learn(step, lost)
    before = Secant()
    before.learn(*secant._pairs[0])
    if step @ lost >= LEAST_PART * step @ before.corrected(curvature) @ step:
        assert np.allclose(secant.corrected(curvature) @ step, lost)


def test_curvature_of_a_quadratic_is_found_along_what_was_gone():
    """As many conjugate steps as it has dimensions give it whole (Nocedal and Wright 2006, theorem 6.4)."""
    rng = np.random.default_rng(3)
    n = PAIRS
    true = positive(rng, n)
    secant, conjugate = Secant(), np.linalg.inv(np.linalg.cholesky(true)).T
    for step in conjugate.T:
        secant.learn(step, true @ step)
    assert np.allclose(secant.corrected(0.5 * true + 0.1 * np.eye(n)), true)


def test_only_the_last_steps_count():
    secant, other = Secant(), Secant()
    rng = np.random.default_rng(4)
    true, pairs = positive(rng, 3), rng.normal(size=(PAIRS, 3))
    secant.learn(np.ones(3), 100 * np.ones(3))
    for one in (secant, other):
        for step in pairs:
            one.learn(step, true @ step)
    assert (secant.corrected(np.eye(3)) == other.corrected(np.eye(3))).all()


def test_a_step_that_went_nowhere_tells_nothing():
    secant = Secant()
    secant.learn(np.zeros(3), np.ones(3))
    assert (secant.corrected(np.eye(3)) == np.eye(3)).all()


def fitted_far_off(simulation, *names):
    """A fit of what is another cause, at its start: what is left is large, and the model bends."""
    every = [forms_of(find_effect(name), {"zone": ZONES, "bin": BINS}) for name in names]
    forms = tuple(max([f for f in some if f.own][:6], key=lambda f: len(f.coordinates)) for some in every)
    starts = [start_of(form, np.full(400, 0.01)) for form in forms]
    gain = simulation.counts.sum() / simulation.expected(1.0).sum()
    return Descent(simulation, forms, np.concatenate([[np.log(gain)], *starts]), 0.0)


def test_where_much_is_left_a_fit_comes_to_its_best(drawn):
    """As a minimiser without derivatives finds it (Powell 1964) that goes on from there."""
    far_off = fitted_far_off(drawn(1, "impulse_tail", share=0.8, tau=2e-9), "gain_drift", "zone_gain")
    x, end = far_off.x, far_off.run().deviance
    nuisances = far_off.nuisances

    def at(y):
        y = np.clip(y, far_off.low, far_off.high)
        return deviance_at(nuisances, far_off.forms, y, expected_at(far_off.simulation, far_off.forms, y))

    assert end < at(x) - 1e5
    assert minimize(at, far_off.x, method="Powell", options={"maxfev": 1500}).fun > end - 1e-4 * end


def test_which_of_both_is_used_is_said_by_the_last_step():
    """And none that is learnt before a step had to be damped."""
    true, step = np.diag([4.0, 1.0]), np.array([1.0, 0.0])
    for foretold, damped in itertools.product([False, True], repeat=2):
        secant, information = Secant(), np.eye(2)
        secant.curvature(np.array([4.0, 0.0]), information)
        secant.took(0.5 * step, 3.0, damped)
        secant.curvature(np.array([2.0, 0.0]), information)
        won = 1.0 if foretold else 1.75
        secant.took(0.5 * step, won, False)
        found = secant.curvature(np.zeros(2), information)
        assert np.allclose(found, true if foretold and damped else information)


def test_information_that_is_too_stiff_is_doubted():
    """Which a step says that wins nearly twice what it foretold; one and a half times that is not yet said."""
    for more, doubted in ((1.4, False), (1.9, True)):
        secant, information = Secant(), 10 * np.eye(2)
        secant.curvature(np.array([10.0, 0.0]), information)
        secant.took(np.array([1.0, 0.0]), more * 10.0, False)
        secant.curvature(np.array([7.0, 0.0]), information)
        secant.took(np.array([1.0, 0.0]), 11.0 if doubted else 5.0, False)
        found = secant.curvature(np.array([4.0, 0.0]), information)
        assert np.allclose(found, np.diag([3.0, 10.0]) if doubted else information)


def test_what_has_many_numbers_keeps_its_information():
    secant, information, gradient = Secant(), np.eye(MANY + 1), np.ones(MANY + 1)
    for _ in range(3):
        assert secant.curvature(gradient, information) is information
        secant.took(gradient, 0.0, True)


def test_without_what_steps_tell_it_creeps(drawn, monkeypatch):
    """Of a strong delay what levels of time zero and gains of zones leave."""
    simulation = drawn(1, "time_zero_offset", delay=1e-9)
    descents = [fitted_far_off(simulation, "time_zero_drift", "zone_gain") for _ in range(2)]
    end = descents[0].run().deviance
    monkeypatch.setattr(Secant, "corrected", lambda _, curvature: curvature)
    assert end < 0.8 * descents[1].run().deviance

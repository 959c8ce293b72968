"""The black box against a general minimiser, on a change it can make, and beyond what it has seen."""

import numpy as np
import pytest
from scipy.optimize import minimize

from mismatch.black_box import _fitted, fit_black_box
from mismatch.covariates import covariates
from mismatch.fit import fit_nominal, on_others
from mismatch.poisson import deviance, expected_deviance

from .conftest import FRAMES


def test_weights_are_those_of_a_general_minimiser():
    rng = np.random.default_rng(1)
    design, mean, penalty = rng.normal(size=(200, 3)), rng.uniform(5, 50, 200), np.diag([1.0, 20.0, 0.1])
    counts = rng.poisson(mean * np.exp(design @ [0.2, -0.1, 0.3]))

    def loss(weights):
        there = mean * np.exp(design @ weights)
        return 2 * (there - counts * np.log(there)).sum() + weights @ penalty @ weights

    oracle = minimize(loss, np.zeros(3), method="BFGS")
    np.testing.assert_allclose(_fitted(design, counts, mean, penalty), oracle.x, atol=1e-3)


@pytest.fixture(scope="module")
def bent(rig, simulated):
    """Counts that exceed what is simulated by a smooth function of time in the pulse."""
    plain = rig.expected()
    found = covariates(simulated(plain.round()), plain)
    after = np.arange(plain.shape[2]) + 0.5 - found.arrival_bins[..., None]
    counts = np.random.default_rng(2).poisson(plain * (1 + 0.3 * np.sin(after / 2.5)))
    return simulated(counts)


def test_a_smooth_change_is_learnt_and_holds_on_frames_held_out(bent):
    chosen, held = np.arange(0, FRAMES, 2), np.arange(1, FRAMES, 2)
    train, test = bent.of(chosen), bent.of(held)
    nominal = fit_nominal(train)
    box = fit_black_box(train, nominal.expected)
    before, lost = on_others(test, nominal)
    after = box.expected(test, before)
    noise = expected_deviance(after)[0].sum()
    assert deviance(test.counts, after).sum() - noise < 0.15 * (lost - noise)


def test_where_nothing_is_wrong_little_is_changed(drawn):
    simulation = drawn(3)
    nominal = fit_nominal(simulation).expected
    box = fit_black_box(simulation, nominal)
    change = np.abs(box.expected(simulation, nominal) / nominal - 1)[nominal > 50]
    assert np.median(change) < 0.02


def test_beyond_what_was_seen_the_correction_stays_what_it_is_at_the_end(bent):
    nominal = fit_nominal(bent)
    box = fit_black_box(bent, nominal.expected)
    # So much brighter than anything before that all of it is at the end.
    once, twice = (box.expected(bent, times * nominal.expected) / times for times in (1e6, 1e7))
    np.testing.assert_allclose(once, twice, rtol=1e-3)

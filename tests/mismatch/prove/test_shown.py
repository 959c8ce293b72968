"""What a cause moves, at the best gain, found here by search."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from mismatch.prove.shown import MOVED, moved, strength_for

RNG = np.random.default_rng(4)
DARK = np.full((3, 2, 20), 1.5)
NOMINAL = DARK + RNG.gamma(1.0, 20.0, DARK.shape)


def test_a_gain_moves_nothing_though_the_background_keeps_its_own():
    for gain in (1.3, 0.02, 0.0):
        assert moved(DARK + gain * (NOMINAL - DARK), NOMINAL, DARK) == pytest.approx(0, abs=1e-3)


def test_it_is_twice_the_log_likelihood_that_the_best_gain_lacks():
    there = NOMINAL * RNG.uniform(0.7, 1.5, (1, 2, 1)) + 1

    def cost(log_gain):
        mean = DARK + np.exp(log_gain) * (NOMINAL - DARK)
        # Counts need not be whole: what the probability of one adds is the same in both terms.
        return 2 * float((there * np.log(there / mean) - there + mean).sum())

    assert moved(there, NOMINAL, DARK) == pytest.approx(minimize_scalar(cost, (-0.5, 0.5)).fun, rel=1e-3)


@pytest.mark.parametrize("power", [1, 2])
def test_the_strength_is_found_that_moves_so_much(power):
    strength = strength_for(lambda s: 3e4 * s**power, 1000.0)
    assert 800 < 3e4 * strength**power < 1250


def test_what_shows_less_than_any_must_has_no_strength():
    assert strength_for(lambda s: MOVED[0] / 2, 1000.0) is None
    assert strength_for(lambda s: min(1e3 * s, 2 * MOVED[0]), 5000.0) is not None

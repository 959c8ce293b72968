"""What lags explain to first order, against counts that follow them exactly."""

import numpy as np
import pytest

from physics.lags_told import evenly, promised

TIMES = np.linspace(0, 2, 40)


def told_and_found(lags, seed=3, noise=0.0):
    """(F, P) each: information, and score of lags (F, P) that are so large, with photons' scatter or none."""
    rng = np.random.default_rng(seed)
    told = rng.uniform(50, 200, (40, 6))
    return told, told * lags + noise * np.sqrt(told) * rng.normal(size=told.shape)


@pytest.mark.parametrize(("lag", "skew"), [(0.3, 0.0), (0.0, -0.2), (0.1, 0.4)])
def test_lags_that_go_with_time_are_found(lag, skew):
    told, found = told_and_found((lag + skew * TIMES)[:, None])
    *_, both = evenly(told.sum(axis=1), found.sum(axis=1), TIMES)
    assert both == pytest.approx({"lag": lag, "skew": skew}, abs=1e-9)


def test_noise_promises_nothing_and_lags_what_they_gain():
    noise = np.array([promised(*told_and_found(0.0, seed, 1.0), TIMES) for seed in range(400)])
    assert np.quantile(noise, 0.99) < 20
    told, found = told_and_found(np.array([0.2, 0, 0, 0, 0, 0]))
    # Deviance of a normal mean that is off by it: its square over its variance.
    assert promised(told, found, TIMES) == pytest.approx(0.2**2 * told[:, 0].sum() - 6)

"""Waiting against scipy's generalised Pareto distribution, and its integral by quadrature."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.stats import genpareto

from physics.waits import half_life, late, reach, steps_late, waiting

HEAVY = [-1.0, -0.5, 0.0, 1e-7, 0.3, 1.0, 2.0]


@pytest.mark.parametrize("heavy", HEAVY)
def test_it_is_the_generalised_pareto_distribution(heavy):
    times = np.linspace(0, 5e-9, 50)
    np.testing.assert_allclose(waiting(times, 7e-10, heavy), genpareto.sf(times, heavy, scale=7e-10), atol=1e-6)
    assert half_life(7e-10, heavy) == pytest.approx(genpareto.median(heavy, scale=7e-10), rel=1e-6)


@pytest.mark.parametrize("heavy", HEAVY)
def test_a_step_s_light_waits_as_the_average_over_the_step_does(heavy):
    step, tau = 1e-10, 3e-10
    found = steps_late(6, step, tau, heavy)
    for k in range(6):
        inside = quad(
            lambda left, k=k: np.diff(genpareto.cdf([(k - left) * step, (k + 1 - left) * step], heavy, scale=tau))[0],
            0,
            1,
            points=[0.5],
        )[0]
        assert found[k] == pytest.approx(inside, abs=1e-6)


@given(tau=st.floats(1e-11, 2e-9), heavy=st.floats(-1, 2), at=st.integers(0, 20))
def test_light_is_kept_within_reach_and_none_comes_early(tau, heavy, at):
    step = 5e-11
    light = np.zeros((2, at + 2 + int(reach(tau, heavy) / step)))
    light[1, at] = 1.0
    found = late(light, step, tau, heavy)
    assert (found >= 0).all()
    assert not found[0].any()
    assert found[1, :at].max(initial=0) < 1e-12
    # A power law ends within a step, a little of it on either side.
    assert found[1].sum() == pytest.approx(1, abs=2e-3 if heavy > 1e-6 else 1e-6)

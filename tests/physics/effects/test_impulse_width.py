"""A stretched Gaussian is the Gaussian of the stretched width, in closed form."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.stats import norm

from physics.arrivals import arrivals
from physics.clock import Clock
from physics.effects.impulse_width import effect
from physics.nominal import ForwardModel
from physics.pulse import ImpulseResponse, tailed_pulse
from physics.rendering import Rendering

SIGMA, MEAN, STEP = 0.15e-9, 0.04e-9, 0.0125e-9


def gaussian():
    edges = (np.arange(-80, 82) - 0.5) * STEP
    probability = np.diff(norm.cdf(edges, loc=MEAN, scale=SIGMA))
    return ImpulseResponse((edges[1:] + edges[:-1]) / 2, probability / probability.sum())


def stretched(pulse, broader, jitter=0.0, centred=1.0, even=0.0):
    start = Rendering(None, None, Clock(0.4e-9, 60, np.zeros(1), pulse), 1.0)
    return effect.clock(effect.at(broader=broader, jitter=jitter, centred=centred, even=even).values, start).pulse


@pytest.mark.parametrize("broader", [-0.6, -0.1, 1e-3, 0.5, 3.0])
def test_a_gaussian_stays_one(broader):
    times = np.linspace(-2e-9, 2e-9, 300)
    closed = norm.cdf(times, loc=MEAN, scale=SIGMA * (1 + broader))
    # Between its steps' edges a response is spread evenly: the bow of the narrowest Gaussian within a step.
    atol = (STEP / (SIGMA * (1 + broader))) ** 2 / 8 * 0.25 + 1e-4
    np.testing.assert_allclose(stretched(gaussian(), broader).cumulative(times), closed, atol=atol)


@pytest.mark.parametrize("centred", [0.0, 0.3])
def test_about_the_nominal_arrival_the_mean_moves_too(centred):
    times = np.linspace(-2e-9, 2e-9, 300)
    pivot = centred * MEAN
    closed = norm.cdf(times, loc=pivot + 1.5 * (MEAN - pivot), scale=1.5 * SIGMA)
    np.testing.assert_allclose(stretched(gaussian(), 0.5, centred=centred).cumulative(times), closed, atol=1e-3)


@given(broader=st.floats(-0.5, 4))
def test_light_and_mean_are_kept_and_the_width_follows(broader):
    pulse = tailed_pulse(0.1e-9, 0.2e-9, 0.4e-9, 0.2, STEP)
    found = stretched(pulse, broader)
    assert found.probability.sum() == pytest.approx(1, abs=1e-12)
    assert (found.probability >= 0).all()
    assert found.step_s == pytest.approx(STEP)
    means, widths = zip(*(_moments(p) for p in (pulse, found)), strict=True)
    assert means[1] == pytest.approx(means[0], abs=0.01 * STEP)
    # A step's own width, which reading the cumulative at edges leaves out, is allowed for.
    assert widths[1] == pytest.approx(widths[0] * (1 + broader), abs=0.02 * STEP + 5e-3 * widths[0])


@pytest.mark.parametrize("jitter", [1e-13, 2e-11, 1e-10, 8e-10])
def test_jitter_makes_a_gaussian_a_wider_one(jitter):
    """Variances add, that of a step, over which the response is even, among them."""
    times = np.linspace(-3e-9, 3e-9, 300)
    closed = norm.cdf(times, loc=MEAN, scale=np.hypot(SIGMA, jitter))
    np.testing.assert_allclose(stretched(gaussian(), 0, jitter).cumulative(times), closed, atol=6e-4)


@pytest.mark.parametrize("even", [1e-9, 0.3, 0.9, 1.0])
def test_jitter_that_is_partly_even(even):
    """Against quadrature: the mean, over the even part, of what the normal part makes of a Gaussian."""
    times, jitter = np.linspace(-2e-9, 2e-9, 200), 2e-10
    late = jitter * np.sqrt(3 * even) * (np.arange(2000) + 0.5 - 1000) / 1000
    closed = norm.cdf(times[:, None], MEAN + late, np.hypot(SIGMA, jitter * np.sqrt(1 - even))).mean(axis=1)
    found = stretched(gaussian(), 0, jitter, even=even).cumulative(times)
    np.testing.assert_allclose(found, closed, atol=6e-4)


@given(broader=st.floats(-0.5, 2), jitter=st.floats(0, 5e-10), even=st.floats(0, 1))
@example(broader=1.0, jitter=1.4658551829388472e-11, even=0.0)
@example(broader=0.0, jitter=5e-10, even=5e-10)
@example(broader=0.0, jitter=2.84e-11, even=1.0)
def test_jitter_keeps_light_and_mean_and_adds_its_variance(broader, jitter, even):
    pulse = tailed_pulse(0.1e-9, 0.2e-9, 0.4e-9, 0.2, STEP)
    narrow, wide = stretched(pulse, broader), stretched(pulse, broader, jitter, even=even)
    assert wide.probability.sum() == pytest.approx(1, abs=1e-12)
    (mean, width), (other, wider) = (_moments(p) for p in (narrow, wide))
    assert other == pytest.approx(mean, abs=1e-3 * STEP)
    # Blurred, light within a step is told apart by its step: where a delay ends at the part f of one, by f (1 - f) of a
    # step squared more, a sixth in the mean; 3/16 in that over delays up to three quarters of a step.
    rounding = 1e-6 * width**2
    assert -rounding <= wider**2 - width**2 - jitter**2 <= 3 / 16 * STEP**2 + rounding


def _moments(pulse):
    mean = pulse.probability @ pulse.time_s
    return mean, np.sqrt(pulse.probability @ (pulse.time_s - mean) ** 2)


@pytest.mark.parametrize("even", [0.0, 0.7])
def test_clocks_of_zones_may_jitter_by_different_amounts(small, even):
    model, jitters = ForwardModel(small.light, small.footprints, small.clock), np.array([3e-10, 0, 5e-11, 1.2e-10])
    found = model.expected(1e3, [effect.at(jitter=jitters, even=even)])
    for zone, jitter in enumerate(jitters):
        alone = model.expected(1e3, [effect.at(jitter=jitter, even=even)])
        np.testing.assert_allclose(found[:, zone], alone[:, zone], atol=1e-3 * alone.max())


@pytest.mark.parametrize("centred", [1.0, 0.3])
def test_pulses_of_zones_may_be_stretched_by_different_factors(small, centred):
    model, factors = ForwardModel(small.light, small.footprints, small.clock), np.array([0.9, 0, -0.3, 0.03])
    found = model.expected(1e3, [effect.at(broader=factors, centred=centred)])
    for zone, broader in enumerate(factors):
        alone = model.expected(1e3, [effect.at(broader=broader, centred=centred)])
        np.testing.assert_allclose(found[:, zone], alone[:, zone], atol=2e-3 * alone.max())
    assert found.min() >= 0


def test_pulses_of_zones_that_are_the_same_are_one(small):
    """Binned, and registered until any time: each zone by itself as all together."""
    lattice = small.clock.lattice
    here = arrivals(small.light, small.footprints, small.clock)
    each = replace(here, pulses=np.tile(lattice.cumulative, (4, 1)))
    np.testing.assert_array_equal(each.binned(), here.binned())
    times = np.array([3.3, 10.0, 17.9])
    np.testing.assert_array_equal(each.until(times), here.until(times))
    edges, pulse = lattice.edges_s, small.clock.pulse
    np.testing.assert_allclose(lattice.cumulative, pulse.cumulative(edges), atol=1e-3)

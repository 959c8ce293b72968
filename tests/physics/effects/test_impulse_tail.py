"""The tail against the exponentially modified Gaussian in closed form (scipy's, from the literature)."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import exponnorm, genpareto, norm

from physics.clock import Clock
from physics.effects.impulse_tail import effect
from physics.nominal import ForwardModel
from physics.pulse import ImpulseResponse
from physics.rendering import Rendering
from recordings.refusal import Refusal

SIGMA = 0.15e-9


def gaussian(step_s):
    edges = (np.arange(-80, 82) - 0.5) * step_s
    probability = np.diff(norm.cdf(edges, scale=SIGMA))
    return ImpulseResponse((edges[1:] + edges[:-1]) / 2, probability / probability.sum())


def tailed(share, tau, step_s=0.0125e-9, **lingering):
    clock = Clock(0.4e-9, 60, np.zeros(1), gaussian(step_s))
    start = Rendering(None, None, clock, 1.0)
    return effect.clock(effect.at(share=share, tau=tau, **lingering).values, start).pulse


@pytest.mark.parametrize("tau", [0.02e-9, 0.3e-9, 1e-9])
def test_all_delayed_is_the_exponentially_modified_gaussian(tau):
    times = np.linspace(-0.5e-9, 4e-9, 200)
    closed = exponnorm.cdf(times, K=tau / SIGMA, scale=SIGMA)
    np.testing.assert_allclose(tailed(1.0, tau).cumulative(times), closed, atol=1e-3)


@pytest.mark.parametrize("duration", [0.03e-9, 0.6e-9, 2e-9])
def test_a_laser_that_lingers_leaves_a_plateau(duration):
    times = np.linspace(-0.5e-9, 4e-9, 200)

    def integral(x):  # Of the normal distribution: what a uniform delay makes of it is a difference of two.
        return x * norm.cdf(x, scale=SIGMA) + SIGMA**2 * norm.pdf(x, scale=SIGMA)

    closed = (integral(times) - integral(times - duration)) / duration
    found = tailed(0.0, 1e-10, lingering=1.0, duration=duration)
    np.testing.assert_allclose(found.cumulative(times), closed, atol=1e-3)


@given(share=st.floats(0, 1), duration=st.floats(1e-11, 6e-9))
def test_a_plateau_keeps_photons_and_is_late_by_half_of_its_duration(share, duration):
    found = tailed(0.0, 1e-10, lingering=share, duration=duration)
    assert found.probability.sum() == pytest.approx(1, abs=1e-12)
    assert (found.probability >= -1e-18).all()
    later = found.probability @ found.time_s - gaussian(0.0125e-9).probability @ gaussian(0.0125e-9).time_s
    assert later == pytest.approx(share * duration / 2, rel=1e-6, abs=1e-17)


@given(share=st.floats(0, 1), tau=st.floats(1e-12, 2e-9))
def test_photons_are_kept_and_come_later_on_average_by_share_times_tau(share, tau):
    found = tailed(share, tau)
    assert found.probability.sum() == pytest.approx(1, abs=1e-12)
    assert (found.probability >= -1e-18).all()
    later = found.probability @ found.time_s - gaussian(0.0125e-9).probability @ gaussian(0.0125e-9).time_s
    assert later == pytest.approx(share * tau, rel=1e-6, abs=1e-17)


def test_it_is_in_proportion_at_all_ranges(small):
    from physics.nominal import ForwardModel

    near = ForwardModel(small.light, small.footprints, small.clock)
    far = ForwardModel(
        small.light,
        small.footprints,
        replace(small.clock, time_zero_s=small.clock.time_zero_s + 3 * small.clock.bin_width_s),
    )
    setting = [effect.at(share=0.5)]
    np.testing.assert_allclose(far.expected(1.0, setting)[..., 3:], near.expected(1.0, setting)[..., :-3], atol=1e-12)


def test_what_falls_more_slowly_is_no_tail_nor_what_is_over_within_a_bin(small):
    with pytest.raises(Refusal, match=r"tau is 2\.5e-09, expected 1e-12 to 2e-09 s"):
        effect.at(share=0.1, tau=2.5e-9)
    seen = Rendering(small.light, small.footprints, small.clock, 1.0)
    assert effect.strained(effect.at(share=0.1, tau=1.6e-9, heavy=0.9).values, seen)
    assert not effect.strained(effect.at(share=0.1, tau=1.6e-9, heavy=0.1).values, seen)
    assert not effect.strained(effect.at(share=0.0, tau=1.6e-9, heavy=0.9).values, seen)
    # Bins are 0.26 ns wide.
    assert effect.strained(effect.at(share=0.1, tau=0.04e-9).values, seen)
    assert not effect.strained(effect.at(share=0.1, tau=0.06e-9).values, seen)


@pytest.mark.parametrize(("tau", "heavy"), [(0.3e-9, -0.5), (0.2e-9, 0.6), (0.1e-9, 1.0), (0.4e-9, 2.0)])
def test_tails_that_fall_otherwise_are_those_of_pareto(tau, heavy):
    """The normal distribution's cumulative, averaged over scipy's delays; but for what waits longer than 20 ns."""
    times, chances = np.linspace(-0.4e-9, 4e-9, 60), (np.arange(20000) + 0.5) / 20000
    within = genpareto.cdf(2e-8, heavy, scale=tau)
    waits = genpareto.ppf(chances * within, heavy, scale=tau)
    closed = norm.cdf(times[:, None] - waits, scale=SIGMA).mean(axis=1)
    found = tailed(1.0, tau, heavy=heavy)
    assert (found.probability >= 0).all()
    np.testing.assert_allclose(found.cumulative(times), closed, atol=1.5e-3)


@pytest.mark.parametrize(("tau", "heavy"), [(0.1e-9, 0.0), (0.7e-9, 0.0), (0.7e-9, -0.5), (0.3e-9, 0.4)])
def test_each_zone_may_have_a_tail_of_its_own(small, tau, heavy):
    """As with sensors all of whose zones have that tail; light from before the first bin is another matter."""
    model, shares = ForwardModel(small.light, small.footprints, small.clock), np.array([0.5, 0, 0.1, 0.9])
    found = model.expected(1e3, [effect.at(share=shares, tau=tau, heavy=heavy)])
    for zone, share in enumerate(shares):
        alone = model.expected(1e3, [effect.at(share=share, tau=tau, heavy=heavy)])
        np.testing.assert_allclose(found[:, zone], alone[:, zone], atol=1e-4 * alone.max())

"""What an estimated clock may be off by: slopes against renderings, and models compared with all of it fitted."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.stats import poisson

from mismatch import clock_slopes as module
from mismatch.clock_slopes import OF_DELAY, clock_slopes, longer
from mismatch.explain import explain
from mismatch.fit import fit, fit_nominal
from mismatch.form import forms_of
from mismatch.improved import improved_sensor
from mismatch.noise import Nuisances
from mismatch.open_simulation import simulation_of
from physics.effects import find_effect
from physics.pulse import ImpulseResponse

from .conftest import FRAMES, WIDTH_S, ZONES


@pytest.fixture(scope="module")
def slopes(drawn, rig):
    simulation = drawn(1)
    return simulation, clock_slopes(simulation, rig.gain), rig.gain


def test_delays_of_zones_change_counts_as_renderings_say(slopes):
    simulation, found, gain = slopes
    step = 0.02 * OF_DELAY * WIDTH_S
    for zone in range(ZONES):
        late = np.zeros(ZONES)
        late[zone] = step
        later, earlier = (
            replace(simulation, clock=replace(simulation.clock, time_zero_s=simulation.clock.time_zero_s + sign * late))
            for sign in (1, -1)
        )
        change = (later.expected(gain) - earlier.expected(gain)) / 0.04
        assert np.linalg.norm(change - found[zone - ZONES]) < 0.02 * np.linalg.norm(change)


def test_zones_whose_time_zeros_hold_are_not_late(slopes):
    simulation, found, gain = slopes
    np.testing.assert_array_equal(clock_slopes(replace(simulation, timed=True), gain), found[:-ZONES])


def test_pieces_of_the_response_change_counts_as_renderings_say(slopes):
    """Any response is a mixture: of the one there is, and of one that is a piece of it alone."""
    simulation, found, gain = slopes
    clock = longer(simulation.clock, 8, 47)
    probability = clock.pulse.probability / clock.pulse.probability.sum()
    pieces = module._pieces(probability, clock.lattice.per_bin)
    assert len(pieces) > 20
    assert np.abs(np.sum(pieces, axis=1)).max() < 1e-12
    before = replace(simulation, clock=clock).expected(gain)
    reach = len(found) - ZONES
    for k in (5, reach // 3, reach // 2):
        changed = probability + 1e-3 * pieces[k]
        pulse = ImpulseResponse(clock.pulse.time_s, np.maximum(changed, 1e-13))
        after = replace(simulation, clock=replace(clock, pulse=pulse)).expected(gain)
        change = (after - before) / 1e-3
        nearest = min(np.linalg.norm(change - one) for one in found[:reach])
        assert nearest < 0.02 * np.linalg.norm(change)


def test_a_clock_that_would_take_too_many_numbers_is_kept(slopes, monkeypatch):
    monkeypatch.setattr(module, "MOST_NUMBERS", 1000)
    assert clock_slopes(slopes[0], 1.0) is None


def test_a_dead_zone_changes_nothing(slopes):
    simulation, found, gain = slopes
    dead = replace(simulation, dead=np.arange(ZONES) == 2)
    without = clock_slopes(dead, gain)
    assert not without[:, :, 2].any()
    assert len(without) == len(found) - 1


@pytest.fixture
def loose(drawn, rig):
    """A simulation that is off by known numbers of three directions, and those numbers."""
    simulation = drawn(2)
    rng, expected = np.random.default_rng(3), simulation.expected(rig.gain)
    ways = 0.02 * np.stack([np.roll(expected, k, axis=2) - expected for k in (1, 3)] + [expected * rng.random((4, 1))])
    true = np.array([1.2, -0.7, 0.4])
    counts = rng.poisson(expected + np.tensordot(true, ways, 1)).astype(float)
    return replace(simulation, counts=counts, loose=ways), true


def penalised(simulation, expected, sigma=0.0):
    """By scipy: least -2 log-likelihood over b, up to what no model changes."""
    ways, counts = simulation.loose, simulation.counts

    def loss(b):
        mean = np.maximum(expected + np.tensordot(b, ways, 1), 1e-3)
        return 2 * (poisson.logpmf(counts, counts).sum() - poisson.logpmf(counts, mean).sum()) + b @ b

    return minimize(loss, np.zeros(len(ways)), method="BFGS")


def test_the_clock_settles_where_the_penalised_likelihood_is_greatest(loose, rig):
    simulation, true = loose
    expected = simulation.expected(rig.gain)
    nuisances, best = Nuisances(simulation, 0.0), penalised(simulation, expected)
    assert nuisances.deviance(expected) == pytest.approx(best.fun, abs=0.1)
    np.testing.assert_allclose(best.x, true, atol=0.4)
    mean = expected + np.tensordot(best.x, simulation.loose, 1)
    np.testing.assert_allclose(nuisances.applied(expected), mean, rtol=2e-3, atol=1e-2)
    off = replace(simulation, loose=None)
    assert Nuisances(off, 0.0).deviance(expected) > nuisances.deviance(expected) + 50


@pytest.mark.parametrize("sigma", [0.0, 0.02])
def test_changes_are_multiplied_by_the_inverse_covariance_of_photons_gains_and_clock(loose, rig, sigma):
    simulation = loose[0].of(np.arange(2))
    expected = simulation.expected(rig.gain)
    nuisances = Nuisances(simulation, sigma)
    mean, settled = nuisances.applied(expected), nuisances.settled(expected).mean
    covariance = np.diag(mean.ravel()) + np.tensordot(simulation.loose, simulation.loose, (0, 0)).reshape(
        mean.size, mean.size
    )
    for f in range(2):
        signal = np.zeros_like(mean)
        signal[f] = settled[f] - simulation.dark
        covariance += sigma**2 * np.outer(signal, signal)
    one, other = np.random.default_rng(5).normal(size=(2, *mean.shape))
    wanted = one.ravel() @ np.linalg.solve(covariance, other.ravel())
    assert nuisances.product(expected, one, other) == pytest.approx(wanted, rel=1e-5, abs=1e-4)


def test_slopes_of_a_fit_are_those_of_its_deviance(loose, rig):
    simulation, _ = loose
    nuisances = Nuisances(simulation, 0.0)
    expected = simulation.expected(rig.gain)
    columns = (0.3 * np.roll(expected, 2, axis=2)).reshape(-1, 1)
    score, information = nuisances.normal_equations(expected, columns)

    def deviance(step):
        return nuisances.deviance(expected + step * columns.reshape(expected.shape))

    step = 1e-2
    slope = (deviance(step) - deviance(-step)) / (2 * step)
    bend = (deviance(step) - 2 * deviance(0.0) + deviance(-step)) / step**2
    assert -2 * score[0] == pytest.approx(slope, rel=0.02, abs=2.0)
    assert 2 * information[0, 0] == pytest.approx(bend, rel=0.1)


@pytest.mark.parametrize("sigma", [0.0, 0.02])
def test_a_step_with_the_clocks_information_from_elsewhere_goes_the_same_way(loose, rig, sigma):
    """The score is that with its own; the information is near it."""
    simulation, _ = loose
    nuisances, expected = Nuisances(simulation, sigma), simulation.expected(rig.gain)
    columns = np.stack([(0.3 * np.roll(expected, k, axis=2)).ravel() for k in (7, 12)], axis=1)
    nuisances.deviance(1.1 * expected)
    score, information = nuisances.normal_equations(expected, columns)
    nearly, near = nuisances.normal_equations(expected, columns, nearly=True)
    np.testing.assert_allclose(nearly, score, atol=0.1 * np.sqrt(np.diag(information)).min())
    np.testing.assert_allclose(near, information, rtol=0.2, atol=0.02 * np.abs(information).max())
    assert (near != information).any()


def test_a_shift_that_a_loose_clock_explains_is_no_effect(drawn, rig):
    """All arrivals later: with a clock that is given it stands out, with one that was estimated it does not."""
    simulation = drawn(4, "time_zero_offset", delay=40e-12)
    (form, *_) = forms_of(find_effect("time_zero_offset"), {"zone": 4, "bin": 48})
    won = []
    for one in (simulation, replace(simulation, loose=clock_slopes(simulation, rig.gain))):
        less = fit_nominal(one)
        won.append(less.deviance - fit(one, (form,), np.concatenate([less.x, form.at_start()])).deviance)
    assert won[0] > 500
    assert won[1] < 0.03 * won[0]


def unrecorded(rig, seed, name, **values):
    """A recording under one effect, without response."""
    counts = np.random.default_rng(seed).poisson(rig.expected(find_effect(name).at(**values)))
    return rig.recording(counts, irf=None, irf_time_s=None)


@pytest.mark.slow
def test_without_a_response_a_clock_that_is_fast_is_named_and_the_improved_sensor_agrees(rig):
    recording = unrecorded(rig, 7, "bin_width_error", error=0.004)
    simulation, assumed, _ = simulation_of(recording, rig.maps)
    explained = explain(simulation)
    found = explained.verdict
    assert (found.verdict, [effect.id for effect in found.effects]) == ("explained", ["bin_width_error"])
    error = found.effects[0].parameters[0]
    assert abs(error.value - 0.004) < 3 * error.sigma
    better = improved_sensor(assumed, explained)
    assert explain(simulation_of(recording, rig.maps, better)[0]).verdict.verdict == "agrees"


def test_without_a_response_a_tail_is_part_of_it(rig):
    simulation, _, _ = simulation_of(unrecorded(rig, 7, "impulse_tail", share=0.05, tau=1e-9), rig.maps)
    assert explain(simulation).verdict.verdict == "agrees"


def test_an_estimate_beside_a_model_that_is_far_off_stays_as_it_is(rig):
    far = 300 * rig.expected() + 3e4 * np.arange(FRAMES)[:, None, None]
    simulation = simulation_of(rig.recording(far, irf=None, irf_time_s=None, laser_cycles=None), rig.maps)[0]
    assert simulation.guessed
    assert simulation.loose is None

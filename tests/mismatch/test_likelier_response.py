"""A response that was estimated, made likelier: what an estimate left out, cut off or had late comes back."""

from dataclasses import replace

import numpy as np
import pytest

from mismatch.fit import fit_nominal
from mismatch.likelier_response import likelier_clock
from mismatch.open_simulation import simulation_of
from mismatch.poisson import deviance as deviance_of
from physics.effects import find_effect
from physics.pulse import ImpulseResponse


@pytest.fixture
def counted(rig):
    """A simulation of counts of the nominal model, with the true response on steps of an eighth of a bin."""
    counts = np.random.default_rng(4).poisson(rig.expected())
    simulation, _, _ = simulation_of(rig.recording(counts), rig.maps)
    pulse, step = simulation.clock.pulse, simulation.clock.bin_width_s / 8
    low, high = np.floor(pulse.edges[0] / step), np.ceil(pulse.edges[-1] / step)
    edges = step * np.arange(low, high + 1)
    probability = np.diff(np.interp(edges, pulse.edges, pulse.edge_cumulative))
    clock = replace(
        simulation.clock, pulse=ImpulseResponse((edges[:-1] + edges[1:]) / 2, probability / probability.sum())
    )
    return replace(simulation, clock=clock)


def deviance(simulation, clock):
    return fit_nominal(replace(simulation, clock=clock)).deviance


def test_what_is_true_stays_but_for_noise(counted):
    found = likelier_clock(counted)
    assert abs(deviance(counted, found) - deviance(counted, counted.clock)) < 150
    assert np.abs(found.time_zero_s - counted.clock.time_zero_s).max() < 5e-12


@pytest.mark.parametrize(
    ("name", "values"),
    [("cover_glass_crosstalk", {"counts": 400.0, "delay": 0.0}), ("range_walk", {"walk": 2e-10, "level": 3000.0})],
)
def test_beside_what_is_there_it_stays_too(counted, rig, name, values):
    """Also beside what goes by counts, not by parts of the light."""
    there = (find_effect(name).at(**values),)
    counts = np.random.default_rng(5).poisson(rig.expected(*there)).astype(float)
    recorded = replace(counted, counts=counts)
    found = replace(recorded, clock=likelier_clock(recorded, rig.gain, there))
    before, after = (deviance_of(counts, one.expected(rig.gain, there)).sum() for one in (recorded, found))
    assert abs(after - before) < 150


def test_an_end_that_was_cut_off_comes_back(counted):
    pulse = counted.clock.pulse
    kept = pulse.edge_cumulative[1:] < 0.9
    cut = ImpulseResponse(pulse.time_s[kept], pulse.probability[kept] / pulse.probability[kept].sum())
    short = replace(counted.clock, pulse=cut)
    found = likelier_clock(replace(counted, clock=short))
    lost = deviance(counted, short) - deviance(counted, counted.clock)
    assert lost > 1000
    assert deviance(counted, found) - deviance(counted, counted.clock) < 0.1 * lost
    assert found.pulse.time_s[-1] > cut.time_s[-1]
    assert found.pulse.probability.sum() == pytest.approx(1)


def test_zones_that_were_thought_late_are_not(counted):
    late = np.array([60e-12, -60e-12, 30e-12, -30e-12])
    wrong = replace(counted.clock, time_zero_s=counted.clock.time_zero_s + late)
    found = likelier_clock(replace(counted, clock=wrong))
    np.testing.assert_allclose(found.time_zero_s, counted.clock.time_zero_s, atol=8e-12)


def test_time_zeros_of_zones_that_hold_are_left_as_they_are(counted):
    """What zones share is the response's all the same."""
    zero = counted.clock.time_zero_s
    late = replace(counted, clock=replace(counted.clock, time_zero_s=zero + 60e-12), timed=True)
    found = likelier_clock(late)
    np.testing.assert_array_equal(found.time_zero_s, late.clock.time_zero_s)
    assert deviance(counted, found) - deviance(counted, counted.clock) < 0.1 * (
        deviance(counted, late.clock) - deviance(counted, counted.clock)
    )


def test_a_dead_zone_says_nothing(counted):
    counts = counted.counts.copy()
    counts[:, 1] = 0
    found = likelier_clock(replace(counted, counts=counts))
    assert np.isfinite(found.pulse.probability).all()
    assert found.time_zero_s[1] == counted.clock.time_zero_s[1]


def test_where_the_model_is_far_off_the_clock_stays(counted):
    assert likelier_clock(replace(counted, counts=np.roll(1000 * counted.counts, 9, axis=2))) is counted.clock

"""A coarser impulse response, as long as the counts do not show it."""

import numpy as np

from mismatch.economy import UNNOTICED, economical


def test_it_is_coarser_and_no_different(drawn, rig):
    simulation = drawn(1)
    cheaper = economical(simulation)
    assert cheaper.clock.lattice.per_bin <= simulation.clock.lattice.per_bin
    assert np.ptp(cheaper.clock.pulse.edges) < 0.9 * np.ptp(simulation.clock.pulse.edges)
    there, here = cheaper.expected(rig.gain), rig.expected()
    assert ((there - here) ** 2 / here).sum() < 1.1 * UNNOTICED


def test_where_counts_are_many_it_stays_as_it_is(rig, simulated):
    bright = simulated(np.random.default_rng(2).poisson(1e4 * rig.expected()))
    assert economical(bright) is bright

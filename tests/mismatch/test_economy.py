"""A coarser impulse response, as long as the counts do not show it."""

from dataclasses import replace

import numpy as np
import pytest

from mismatch.economy import UNNOTICED, economical


def test_it_is_coarser_and_no_different(drawn, rig):
    simulation = drawn(1)
    cheaper = economical(simulation)
    assert cheaper.clock.lattice.per_bin <= simulation.clock.lattice.per_bin
    assert np.ptp(cheaper.clock.pulse.edges) < 0.9 * np.ptp(simulation.clock.pulse.edges)
    there, here = cheaper.expected(rig.gain), rig.expected()
    assert ((there - here) ** 2 / here).sum() < 1.1 * UNNOTICED


@pytest.mark.parametrize("steps", [21.95, 6.3])
def test_where_a_bin_holds_no_whole_number_of_steps_the_lattice_is_no_finer(drawn, rig, steps):
    """Of the response itself the lattice has hundreds of knots to a bin."""
    simulation = drawn(1)
    width = simulation.clock.bin_width_s / steps
    clock = replace(simulation.clock, pulse=simulation.clock.pulse.in_steps(width))
    odd = replace(simulation, clock=clock)
    assert odd.clock.lattice.per_bin >= 64
    cheaper = economical(odd)
    assert cheaper.clock.lattice.per_bin <= 16
    there, here = (of.expected(rig.gain) for of in (cheaper, odd))
    assert ((there - here) ** 2 / here).sum() < 1.1 * UNNOTICED


def test_where_counts_are_many_it_stays_as_it_is(rig, simulated):
    bright = simulated(np.random.default_rng(2).poisson(1e4 * rig.expected()))
    assert economical(bright) is bright

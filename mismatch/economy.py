"""A simulation that costs no more than the data can tell: its impulse response on steps as wide as go unnoticed."""

from dataclasses import replace

import numpy as np

from mismatch.fit import Fit, fit_nominal
from mismatch.poisson import LEAST
from mismatch.simulation import Simulation

# Deviance, over all frames, that wider steps may make: 1 would be a whole standard error of some parameter.
UNNOTICED = 0.05


def economical(simulation: Simulation) -> Simulation:
    """The same simulation on a lattice as coarse as the counts let pass."""
    fitted: Fit = fit_nominal(simulation)
    for per_bin in (8, 16, 32):
        steps = simulation.clock.lattice.per_bin // per_bin
        if steps < 2 or simulation.clock.lattice.per_bin % per_bin:
            continue
        clock = replace(simulation.clock, pulse=simulation.clock.pulse.merged(steps))
        coarser = replace(simulation, clock=clock)
        there = coarser.expected(fitted.gain)
        if ((there - fitted.expected) ** 2 / np.maximum(fitted.expected, LEAST)).sum() < UNNOTICED:
            return coarser
    return simulation

"""A simulation that costs no more than the data can tell: its impulse response as short and coarse as may pass."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from mismatch.fit import Fit, fit_nominal
from mismatch.poisson import LEAST
from mismatch.simulation import Simulation
from physics.pulse import ImpulseResponse

# Deviance, over all frames, that wider steps or a shorter response may make: 1 would be a standard error of some
# parameter.
UNNOTICED = 0.05
# Steps to a bin that are tried. Where the response's own steps do not divide a bin its lattice has hundreds of them.
PER_BIN = (8, 16, 32, 64, 128, 256)
# Parts of a response that are tried as nothing, at either end; light that an effect makes brighter shows more of them.
ENDS = (1e-6, 1e-7, 1e-8)


def economical(simulation: Simulation) -> Simulation:
    """The same simulation on a lattice as coarse as the counts let pass, of a response as short."""
    fitted: Fit = fit_nominal(simulation)
    clock = simulation.clock
    wider = (clock.pulse.in_steps(clock.bin_width_s / n) for n in PER_BIN if 2 * n <= clock.lattice.per_bin)
    coarser = _first_unnoticed(simulation, fitted, wider)
    return _first_unnoticed(coarser, fitted, (coarser.clock.pulse.without_ends(part) for part in ENDS))


def _first_unnoticed(simulation: Simulation, fitted: Fit, pulses: Iterable[ImpulseResponse]) -> Simulation:
    """The simulation with the first of these responses that makes no difference to a fit; as it is where all do."""
    for pulse in pulses:
        other = replace(simulation, clock=replace(simulation.clock, pulse=pulse))
        change = other.expected(fitted.gain) - fitted.expected
        if (change**2 / np.maximum(fitted.expected, LEAST)).sum() < UNNOTICED:
            return other
    return simulation

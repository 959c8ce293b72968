"""A response that was estimated from zones in the wrong order, estimated anew from zones in the order they are in."""

from dataclasses import replace

import numpy as np

from mismatch.blocks import halves
from mismatch.clock_slopes import loosened
from mismatch.fit import fit_nominal
from mismatch.likelier_response import likelier_clock
from mismatch.poisson import deviance
from mismatch.simulation import Simulation
from physics.effects import find_effect

# Part of the deviance of the frames that choose that another order may leave, to be believed so far.
HALF = 0.5
# Bins by which the response is smoothed before it is told anew: what zones in the wrong order wrote into it within a
# bin would stay for hundreds of steps.
SMOOTH_BINS = 0.5


def told_in_order(simulation: Simulation) -> Simulation:
    """The simulation with the response likeliest where zones are in the order that fits best, if that fits far better.

    Pulses laid over one another that are other zones' are smeared by as much as these zones differ; beside such a
    response zones in their right order leave much, which takes other names. What has been estimated by then is the
    response alone: the order takes its name, or not, where all effects are sought.
    """
    effect = find_effect("mirrored_zones")
    if not simulation.guessed or any(setting.effect is effect for setting in simulation.given):
        return simulation
    part = simulation.of(halves(len(simulation.counts))[0])
    nominal = fit_nominal(part)
    *_, best = effect.starts(part.counts - nominal.expected, nominal.expected, part.rendering(nominal.gain))
    if np.array_equal(best["place"], np.arange(len(best["place"]))):
        return simulation
    setting = effect.at(**best | {"reordered": 1.0})
    # As the response is, for both: one that is loose follows what its own order would have.
    here, there = (float(deviance(part.counts, part.expected(nominal.gain, s)).sum()) for s in ((), (setting,)))
    if there > HALF * here:
        return simulation
    clock = replace(simulation.clock, pulse=simulation.clock.pulse.blurred(SMOOTH_BINS * simulation.clock.bin_width_s))
    anew = replace(simulation, clock=clock)
    anew = replace(anew, clock=likelier_clock(anew, nominal.gain, (setting,)))
    return anew if simulation.loose is None else loosened(anew)

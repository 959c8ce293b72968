"""Names that gain far less on held-out frames than they should: they stand in for something else."""

import numpy as np
from scipy.stats import norm

from mismatch.candidates import SIGNIFICANT
from mismatch.fit import Fit
from mismatch.places import Place, wherever
from mismatch.simulation import Simulation
from mismatch.verdict import Named

# A true cause whose formula is a little different falls short by less than this part.
SHORT = 0.75


def doubts(simulation: Simulation, judged: Fit, effects: tuple[Named, ...]) -> tuple[Place, ...]:
    """What speaks against names, a misfit that has no place each.

    Where a name is right the deviance it gains scatters about what is expected, E, by 2√E, as likelihood ratios do.
    Effects that look at each frame are left out: what they gain depends on where things happen to be.
    """
    looking = {s.effect.id for s in judged.settings if s.effect.looks(s.values)}
    found = []
    for one in effects:
        expected = max(one.expected_gain, 1.0)
        p_value = float(norm.cdf((one.heldout_gain - expected) / (2 * np.sqrt(expected))))
        if one.id in looking or p_value * len(effects) > SIGNIFICANT or one.heldout_gain > SHORT * expected:
            continue
        gained = f"gains {one.heldout_gain:.0f} on frames held out where {expected:.0f} are due"
        found.append(
            wherever(simulation, p_value * len(effects), f"{one.id} stands in for something else: it {gained}")
        )
    return tuple(found)

"""What a fit leaves beyond noise, wherever and in whatever shape."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
from scipy.stats import norm

from mismatch.afterimages import afterimage
from mismatch.checks import checks
from mismatch.echoes import echoes
from mismatch.fit import Fit
from mismatch.gained import SIGNIFICANT
from mismatch.noise import Nuisances
from mismatch.places import Place, places, wherever
from mismatch.poisson import LEAST
from mismatch.ripples import ripples
from mismatch.simulation import Simulation
from mismatch.stepped import stepped
from mismatch.stuck import stuck
from mismatch.tables import tables
from mismatch.windows import worst_window

# Where counts are trusted less, by how much is a guess that is right to a factor of two in variance; and a response
# that was estimated from half of the frames is off by as much as the other half scatters.
GUESSED = float(norm.sf(np.sqrt(2) * norm.isf(SIGNIFICANT)))

# What is left, as a part of what was explained, that does not make an explanation wrong: formulas of one cause differ
# by as much.
NEGLIGIBLE = 0.03


# Whoever chose asks of the same fit whether to enrich it, whether to doubt it and whether to trust it.
@lru_cache(maxsize=1)
def what_is_left(simulation: Simulation, fitted: Fit) -> tuple[Place, ...]:
    """Places of what a fit leaves beyond noise; none where noise explains it."""
    guess = simulation.trust is not None or (simulation.guessed and simulation.loose is None)
    least = GUESSED if guess else SIGNIFICANT
    looked = tables(simulation, fitted)
    mean = Nuisances(simulation, fitted.frame_gain_sigma).applied(fitted.expected)
    besides = [*checks(simulation, mean), stuck(simulation, mean)]
    besides += ripples(simulation.counts - mean, mean)
    besides.append(afterimage(simulation.counts - mean, mean, simulation.frames))
    besides.append(stepped(simulation, fitted))
    besides += echoes(simulation, fitted.expected, np.maximum(mean, LEAST))
    window = worst_window(simulation, mean)
    many = len(looked) + len(besides) + 1
    found: list[Place] = []
    if many * min(table.p_value for table in looked) < least:
        found += places(simulation, fitted)
    if many * window.p_value < least and not found:
        found.append(replace(window, p_value=window.p_value * many))
    besides = sorted((check for check in besides if many * check.p_value < least), key=lambda check: check.p_value)
    worst = next(iter(besides), None)
    placed = sum(place.gain for place in found)
    for check in besides:
        # What has a place, as a formula that is a little off, may make a wave.
        foreign = check.foreign and (check.certain or not placed)
        place = wherever(simulation, check.p_value * many, check.sentence, foreign)
        if check is worst and place.gain > placed:
            found.append(replace(place, gain=place.gain - placed))  # Of this, places hold a part.
        elif check.certain:
            found.append(place)
    total = max(sum(place.gain for place in found), 1e-12)
    return tuple(replace(place, share=place.gain / total) for place in found)

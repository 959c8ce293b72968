"""A simulation that is far off: its counts are trusted to a part of what is expected, as photon noise is no measure."""

from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from mismatch.fit import Fit, fit_nominal
from mismatch.likelier_response import FAR
from mismatch.places import Place, wherever
from mismatch.poisson import LEAST, deviance
from mismatch.simulation import Simulation

# Deviance per cell that the nominal model is to be off by, where it is tolerated: as much as causes show by that can be
# told from one another.
LEFT = 10.0
# Deviance per cell that is no more than noise, or hardly: whoever comes so near needs no tolerance.
NEAR = 3.0
# Relative errors that are tolerated at least and at most; turns in which error and gain settle.
LEAST_ERROR, MOST_ERROR, TURNS = 1e-3, 1.0, 2


def tolerated(simulation: Simulation) -> tuple[Simulation, float]:
    """The simulation with its counts trusted as far as leaves a misfit of ordinary size, and to what part of each.

    As it is, and 0, where it is of that size.

    Where the nominal model is off by hundreds of standard deviations no model is right to within photon noise. Bright
    cells, which are off by most of these, would then decide alone, and what is a little better there would take any
    name. A model that is off by a part ε of what is expected, cell by cell, makes counts scatter by μ + ε²μ²
    (Kennedy and O'Hagan 2001, J. R. Stat. Soc. B 63, 425: its discrepancy; Wedderburn 1974: quasi-likelihood). With
    such an ε dim light tells as much as bright light.
    """
    fitted = fit_nominal(simulation)
    if fitted.deviance <= FAR * simulation.counts.size:
        return simulation, 0.0
    for _ in range(TURNS):
        recorded = simulation.as_recorded()
        mean = recorded.expected(fitted.gain)
        error = error_leaving(LEFT, recorded.counts, mean)
        simulation = replace(recorded, tolerance=_trust(recorded.counts, mean, error)).trusting(None)
        fitted = fit_nominal(simulation)
    return simulation, error


def in_words(error: float) -> str:
    """What a tolerance means for the numbers of a verdict."""
    return (
        f"The simulation is far off: counts were trusted to {100 * error:.0f} % of what is expected of each, so that"
        " dim light tells as much as bright light; gains and errors are in these terms."
    )


def error_leaving(left: float, counts: np.ndarray, mean: np.ndarray) -> float:
    """Relative error ε of expected counts (F, P, T) beside which the mean deviance of a cell is `left`."""
    each = deviance(counts, mean)

    def beyond(log_error: float) -> float:
        return float((each * _trust(counts, mean, np.exp(log_error))).mean()) - left

    low, high = np.log(LEAST_ERROR), np.log(MOST_ERROR)
    if beyond(low) <= 0:
        return LEAST_ERROR
    return MOST_ERROR if beyond(high) >= 0 else float(np.exp(brentq(beyond, low, high, xtol=1e-3)))


def is_near(simulation: Simulation, fitted: Fit) -> bool:
    """Whether a fit of counts that were trusted less is right for all frames to within noise, or hardly more.

    Each frame by a gain of its own, as these may fluctuate.
    """
    every = (simulation if simulation.whole is None else simulation.whole).as_recorded()
    mean = every.expected(fitted.gain, fitted.settings)
    theirs, due = (counts.sum(axis=(1, 2), keepdims=True) for counts in (every.counts, mean))
    mean = mean * theirs / np.maximum(due, LEAST)
    return float(deviance(every.counts, mean).mean()) < NEAR


def still_off(simulation: Simulation, fitted: Fit) -> Place:
    """What a fit is off by, in a sentence, where counts were trusted less."""
    every = simulation.as_recorded()
    mean = every.expected(fitted.gain, fitted.settings)
    off = 100 * error_leaving(1.0, every.counts, mean)
    names = "the names that were found" if fitted.forms else "the nominal model"
    return wherever(simulation, 0.0, f"{names} are off by {off:.0f} % of what is expected, far more than photon noise")


def _trust(counts: np.ndarray, mean: np.ndarray, error: float) -> np.ndarray:
    """(F, P, T) how far counts are trusted that scatter by μ + ε²μ², where μ is between what is there and expected."""
    return 1 / (1 + error**2 * (counts + mean) / 2)

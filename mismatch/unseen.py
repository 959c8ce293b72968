"""What effects own up to not having seen: how far that lets counts be trusted, and how likely they are then."""

import numpy as np
from scipy.optimize import minimize_scalar

from mismatch.fit import Fit, on_others
from mismatch.noise import Nuisances
from mismatch.poisson import LEAST, deviance
from mismatch.simulation import Simulation
from physics.owning import Unseen

# Counts may be off by so many times what an effect owns up to, in the mean square, and by as little as this; and by as
# much by these powers of it, as what it guesses to be large is so by chance in part.
MOST_TIMES, LEAST_TIMES = 4.0, 0.02
POWERS = (1.0, 0.7, 0.5, 0.35)
# What happens by chance and makes a frame's variance k times the mean is as rare as 1/k² at the most, or that would be
# no mean: twice the logarithm. So many such k are tried; they and what is usual settle in so many turns.
RARE, CHANCES, TURNS = 4.0, 17, 3
# How far a frame is trusted that was taken when nobody saw the scene.
BLIND = 1e-6


def owns_up(fitted: Fit) -> bool:
    """Whether an effect of a fit leaves counts uncertain."""
    return any(setting.effect.owns_up(setting.values) for setting in fitted.settings)


def trust_in(simulation: Simulation, fitted: Fit, together: bool = True) -> np.ndarray | None:
    """(F, P, T) how far counts are trusted with the effects of a fit; None where they are as sure as photons are.

    together: as far as sums of those that are off alike are, not each by itself, and frames that tell nothing not. By
    how much what an effect owns up to is too much or too little the counts of all frames tell, as they tell how much
    their gain fluctuates.
    """
    return _trust(simulation, fitted, together)[0]


def marginal_deviance(simulation: Simulation, fitted: Fit) -> float:
    """Deviance of a fit whose counts scatter as much as it owns up to, with what it costs that they may.

    Twice the negative logarithm of their probability, up to a constant, each cell by itself (a composite likelihood:
    Varin, Reid and Firth 2011, Statistica Sinica 21, 5).
    """
    trust, price = _trust(simulation, fitted, together=False)
    lost = 0.0 if trust is None else float(np.log(trust).sum())
    return on_others(simulation.trusting(trust), fitted)[1] - lost + price


def _trust(simulation: Simulation, fitted: Fit, together: bool) -> tuple[np.ndarray | None, float]:
    """See `trust_in`; and what it costs that its frames are off by more than others by chance."""
    every = simulation if simulation.whole is None else simulation.whole
    found = unseen_of(every, fitted)
    if not found:
        return None, 0.0
    every = every.trusting(None)
    mean = np.maximum(Nuisances(every, fitted.frame_gain_sigma).applied(on_others(every, fitted)[0]), LEAST)
    each = deviance(every.counts, mean)
    more = _more(each, sum(one.variance for one in found) / mean)
    blind = [one.blind for one in found if together and one.blind is not None and one.blind.any()]
    if more is None and not blind:
        return None, 0.0
    most, alike = [one.at_most for one in found if one.at_most is not None], max(one.together for one in found)
    times = np.ones(len(mean))
    for _ in range(0 if more is None or not most else TURNS):
        times = _by_chance(each, more, np.min(most, axis=0), alike)
        # That few are off by much had made all seem so.
        usual = _more(each, times[:, None, None] * more, (1.0,))
        more = more if usual is None else usual / times[:, None, None]
    trust = np.ones(every.counts.shape)
    if more is not None:
        trust = 1 / (1 + times[:, None, None] * more * (alike if together else 1.0))
    for frames in blind:
        trust[frames] = BLIND
    some = slice(None) if simulation.whole is None else simulation.frames
    return trust[some], float(RARE * np.log(times[some]).sum())


def unseen_of(simulation: Simulation, fitted: Fit) -> list[Unseen]:
    """What effects of a fit, and those given beside them, leave uncertain in the frames of a simulation.

    Nothing where a model is off by far more in any case.
    """
    if simulation.tolerance is not None:
        return []
    mine = {setting.effect.id for setting in fitted.settings}
    given = (setting for setting in simulation.given if setting.effect.id not in mine)
    rendering = simulation.rendering(fitted.gain)
    every = (*fitted.settings, *given)
    return [s.effect.unseen(s.values, rendering) for s in every if s.effect.owns_up(s.values)]


def _by_chance(each: np.ndarray, more: np.ndarray, at_most: np.ndarray, alike: float) -> np.ndarray:
    """(F,) how many times the variance `more` (F, P, T) that of each frame is, most likely, where it may be more.

    at_most: (F,) times. alike: how many cells are off alike, and tell as much as one.
    """
    times = 1 + (np.maximum(at_most, 1) - 1) * np.linspace(0, 1, CHANCES)[:, None] ** 2
    loss = np.empty(times.shape)
    for one, lost in zip(times, loss, strict=True):
        wider = 1 + one[:, None, None] * more
        lost[:] = (each / wider + np.log(wider)).sum(axis=(1, 2)) / alike + RARE * np.log(one)
    return times[loss.argmin(axis=0), np.arange(len(each))]


def _more(each: np.ndarray, owned: np.ndarray, powers: tuple[float, ...] = POWERS) -> np.ndarray | None:
    """(F, P, T) variance beyond that of photons, over theirs, most likely where counts have deviances `each`.

    owned: what an effect says of it, which is right up to a factor and a power. None where there is none.
    """

    def loss(log_times: float, powered: np.ndarray) -> float:
        wider = 1 + np.exp(log_times) * powered
        return float((each / wider + np.log(wider)).sum())

    bounds = np.log(LEAST_TIMES), np.log(MOST_TIMES)
    best, found = np.inf, None
    for power in powers:
        powered = owned**power
        least = minimize_scalar(loss, args=(powered,), bounds=bounds, method="bounded")
        if least.fun < best:
            best, found = least.fun, float(np.exp(least.x)) * powered
    return found if best < each.sum() else None

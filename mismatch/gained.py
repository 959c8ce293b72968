"""What one fit gains over another on frames that neither has seen, and what it should gain were it true."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import norm

from mismatch.fit import Fit, on_others
from mismatch.looks import deviance_at
from mismatch.noise import Nuisances
from mismatch.poisson import LEAST
from mismatch.simulation import Simulation

# Chance at which noise is let in, after correction for the number of forms tried.
SIGNIFICANT = 1e-3
# A true cause whose formula is a little different falls short by less than this part; one that looks at each frame, or
# of which nobody saw all, gains more or less as things happen to be in better or worse places.
SHORT, SHORT_ROUGHLY = 0.75, 0.5
# How often frames are drawn to say what an effect that looks should gain.
DRAWS = 8


@dataclass(frozen=True)
class Gained:
    """Of a fit, over one with less in it.

    observed: deviance gained. expected: what it should be were the fuller one right, and scatter: its standard
    deviation then. z: how many standard deviations the change it makes stands out of the noise. deviance: of the fuller
    one.
    """

    observed: float
    expected: float
    z: float
    scatter: float
    deviance: float


def gained(test: Simulation, less: Fit, more: Fit) -> Gained:
    """What `more` gains over `less` on the frames `test`, which took no part in either."""
    nuisances = Nuisances(test, more.frame_gain_sigma)
    now, before = on_others(test, less)
    then, after = on_others(test, more)
    mean, truth = (np.maximum(expected, LEAST) for expected in (now, then))
    change = truth - mean
    information = nuisances.product(now, change, change)
    # A response that was estimated from as many other frames, and is not loose, is off by as much as these scatter.
    variance = 2.0 if test.guessed and test.loose is None else 1.0
    z = nuisances.product(now, change, test.counts - mean) / np.sqrt(max(variance * information, 1e-12))
    # Were `then` true, the deviance gained would be twice the divergence of `now` from it, less what the frames' gains
    # could make of that.
    log = np.log(truth / mean)
    part = information / max(float((change**2 / mean).sum()), 1e-12)
    expected = part * 2 * float((truth * log - truth + mean).sum())
    # Of Poisson counts, each of which gains 2 log: more than 2 √expected where few counts are, that hardly any are due.
    scatter = 2 * float(np.sqrt(part * (truth * log**2).sum()))
    if test.loose is not None:
        # An estimated response takes up of large changes other parts than of small ones.
        as_due = Nuisances(replace(test, counts=then), more.frame_gain_sigma)
        taken = deviance_at(as_due, more.forms, more.x, then)
        expected = deviance_at(as_due, less.forms, less.x, now) - taken
    if any(setting.effect.looks(setting.values) for setting in more.settings):
        # What has looked at these frames stands out by as much as its evidence is worth: the chance that noise makes
        # a likelihood ratio as large as exp(gain/2) is less than its inverse (Markov).
        z = min(z, float(np.sqrt(max(before - after, 0.0))))
        expected, scatter = _if_it_were_true(test, less, more)
    # Each parameter has fitted noise of other frames, too: it makes the fuller one look farther away by one, and gain
    # one less. Numbers that are drawn are shrunk by as much.
    expected = max(expected - 2.0 * (more.numbers - less.numbers), 0.0)
    return Gained(before - after, expected, z, max(scatter, poisson_scatter(expected)), after)


def poisson_scatter(expected: float) -> float:
    """Standard deviation of deviance gained where so much is due: twice its root, as of likelihood ratios."""
    return 2 * float(np.sqrt(max(expected, 1.0)))


def _if_it_were_true(test: Simulation, less: Fit, more: Fit) -> tuple[float, float]:
    """Deviance gained on frames drawn from the fuller fit, things being somewhere in each by chance: mean, scatter."""
    rng = np.random.default_rng(0)
    settings = more.settings
    looking = next(s for s in settings if s.effect.looks(s.values))
    without = test.without(more.gain, settings, looking)
    each = []
    for _ in range(DRAWS):
        mean = looking.effect.at_random(looking.values, without, rng)
        drawn = replace(test.as_recorded(), counts=rng.poisson(mean).astype(float)).trusting(test.trust)
        each.append(on_others(drawn, less)[1] - on_others(drawn, more)[1])
    return float(np.mean(each)), float(np.std(each, ddof=1))


def falls_short(observed: float, expected: float, scatter: float, roughly: bool, tried: int = 1) -> bool:
    """Whether deviance gained on held-out frames is far below what it should be were the name right.

    roughly: whether what it should be is known roughly, as of what looks at each frame.
    """
    short = observed < (SHORT_ROUGHLY if roughly else SHORT) * max(expected, 1.0)
    return short and chance(observed, expected, scatter) * tried < SIGNIFICANT


def chance(observed: float, expected: float, scatter: float) -> float:
    """Of gaining so little where a name is right.

    The gain scatters about what is expected by `scatter`; and what is expected by as much, as it goes with the square
    of a strength, or with how often a thing is there, that as many frames told as well. Both together by √2 times that.
    """
    return float(norm.cdf((observed - max(expected, 1.0)) / (np.sqrt(2) * scatter)))

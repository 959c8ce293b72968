"""Misfit that no division of the cells shows: waves through the residuals, counts that are not photons'."""

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2, gamma, norm, poisson

from mismatch.poisson import LEAST, deviance, expected_deviance
from mismatch.simulation import Simulation

# Powers of two whose remainders are looked at: quantised counts, bits that stick.
STEPS = (2, 4, 8)
# A count recurs that comes more often than so many times either next with its remainder, and so many more.
RECURRING, FEW = 3, 20
# Poisson counts of this mean or more leave every remainder of a division by 2, 4 or 8 alike often, to 1e-3.
EVEN = 14.0
# Mean counts, in every frame, from which a cell's rhythm over many frames is that of normal numbers.
BRIGHT = 3.0
# How much more than photons counts scatter is a guess where they do: only those trusted so far say by how much.
SURE = 0.95
# Mean counts from which a bin takes part in telling when a histogram was registered.
LIT = 1.0


@dataclass(frozen=True)
class Check:
    """A property of noise that the residuals should have. p_value: chance of as much. sentence: what is found.

    foreign: whether a cause whose formula is a little different would never leave such a thing. certain: nor one whose
    formula is quite different.
    """

    p_value: float
    sentence: str
    foreign: bool = False
    certain: bool = False


def checks(simulation: Simulation, expected: np.ndarray) -> list[Check]:
    """All of them, for expected counts (F, P, T); where a model is far off those alone that need no photon noise."""
    counts, mean, trust = simulation.counts, np.maximum(expected, LEAST), simulation.trust
    sure = np.ones(mean.shape, bool) if trust is None else trust > SURE
    alive = np.ones(mean.shape[1], bool) if simulation.dead is None else ~simulation.dead
    excess, mean_alive = (counts - mean)[:, alive], mean[:, alive]
    summed = [(a.sum(axis=1), a.sum(axis=2), a.reshape(len(a), -1)) for a in (excess, mean_alive)]
    rhythms = [beat(*columns, what) for *columns, what in zip(*summed, ("bin", "zone", "cell"), strict=True)]
    recorded, due = np.rint(simulation.recorded), mean if trust is None else mean / trust
    found = [wave(excess / np.sqrt(mean_alive)), *rhythms, *remainders(recorded, due), late(excess, mean_alive)]
    if simulation.tolerance is not None:
        return found
    return [
        *found,
        dispersion(counts[sure], expected[sure]),
        gap(recorded[:, alive], due[:, alive]),
        outlier(counts[:, alive], mean_alive, np.flatnonzero(alive)),
    ]


def wave(white: np.ndarray) -> Check:
    """The strongest wave through frames, zones and bins: of noise, its power is exponentially distributed."""
    power = np.abs(np.fft.fftn(white)) ** 2 / white.size
    # The transform of real numbers holds every wave twice; what does not change at all is the tables' business.
    power.flat[0] = 0
    best = np.unravel_index(int(np.argmax(power)), power.shape)
    # Few counts make residuals whose mean square is not 1.
    strongest = float(power[best]) / max(float((white**2).mean()), 1.0)
    p = float(-np.expm1(power.size / 2 * np.log1p(-np.exp(-min(strongest, 600.0)))))
    turns = [min(k, n - k) for k, n in zip(best, power.shape, strict=True)]
    where = f"{turns[2]} periods over the bins, {turns[0]} over the frames"
    return Check(p, f"a wave runs through the residuals: {where}", foreign=True)


def beat(excess: np.ndarray, mean: np.ndarray, what: str) -> Check:
    """The strongest rhythm over the frames of any bin, zone or cell (F, N) that is bright in all of them."""
    frames, bright = len(mean), np.flatnonzero(mean.min(axis=0) >= BRIGHT)
    white = excess[:, bright] / np.sqrt(mean[:, bright])
    power = np.abs(np.fft.rfft(white, axis=0))[1:] ** 2 / frames
    if frames % 2 == 0:
        # The fastest rhythm has one phase, not two: its power scatters twice as much.
        power[-1] /= 2
    if not power.size:
        return Check(1.0, "")
    best = np.unravel_index(int(np.argmax(power)), power.shape)
    p = float(-np.expm1(power.size * np.log1p(-np.exp(-min(float(power[best]), 600.0)))))
    where = "one cell" if what == "cell" else f"{what} {bright[best[1]]}"
    return Check(p, f"{where} goes up and down {best[0] + 1} times over the frames")


def late(excess: np.ndarray, mean: np.ndarray) -> Check:
    """Whether single histograms, of one zone in one frame, are registered later or earlier than expected.

    The squares of their scores, over the information, have mean 1 and variance 2 and an excess that Poisson's fourth
    cumulant gives: their sum goes as the gamma law of its mean and variance. Bins that expect hardly a count are left
    out: one count there would be all that tells.
    """
    slope = np.where(mean >= LIT, np.gradient(mean, axis=-1), 0.0)
    information = (slope**2 / mean).sum(axis=-1)
    told = information > LEAST
    if not told.any():
        return Check(1.0, "")
    score = (excess * slope / mean).sum(axis=-1)[told]
    z2 = score**2 / information[told]
    variance = (2 + (slope**4 / mean**3).sum(axis=-1)[told] / information[told] ** 2).sum()
    p = float(gamma.sf(z2.sum(), z2.size**2 / variance, scale=variance / z2.size))
    return Check(p, "histograms of single zones and frames come early or late")


def outlier(counts: np.ndarray, mean: np.ndarray, zones: np.ndarray) -> Check:
    """The cell whose count is least likely, by the tails of the Poisson law. zones: numbers of those there are."""
    above, below = poisson.sf(counts - 1, mean), poisson.cdf(counts, mean)
    chance = 2 * np.minimum(above, below)
    frame, zone, time = np.unravel_index(int(np.argmin(chance)), chance.shape)
    p = float(-np.expm1(chance.size * np.log1p(-min(float(chance[frame, zone, time]), 1 - 1e-16))))
    cell = f"frame {frame}, zone {zones[zone]}, bin {time}"
    held = f"{counts[frame, zone, time]:.0f} counts where {mean[frame, zone, time]:.3g} are expected"
    return Check(p, f"single cells are out of place: {cell} holds {held}", foreign=True)


def dispersion(counts: np.ndarray, mean: np.ndarray) -> Check:
    """Whether counts scatter as photons do: total deviance against its expectation, either way."""
    first, variance = expected_deviance(mean)
    z = float((deviance(counts, mean) - first).sum() / np.sqrt(variance.sum()))
    more = "more" if z > 0 else "less"
    return Check(
        float(2 * norm.sf(abs(z))), f"counts scatter {more} than photons do, by {abs(z):.1f} standard deviations"
    )


def remainders(counts: np.ndarray, mean: np.ndarray) -> list[Check]:
    """Whether counts leave every remainder alike often, in the zone where they do so least.

    But for cells about as bright as its largest count: that of a full counter comes often, whatever its remainder. One
    that was full for part of the session is known by a count that comes more often than others of its remainder.
    """
    out = []
    for step in STEPS:
        worst, where = 1.0, 0
        for zone in range(counts.shape[1]):
            seen, bright = counts[:, zone], mean[:, zone]
            below = bright + 2 * np.sqrt(bright) < seen.max()
            many = seen[below & (bright >= EVEN * (step / 4) ** 2)].astype(np.int64)
            if len(many) < 10 * step:
                continue
            many = _not_recurring(many, step)
            found = np.bincount(many % step, minlength=step)
            p = float(chi2.sf(((found - len(many) / step) ** 2).sum() / (len(many) / step), step - 1))
            if p < worst:
                worst, where = p, zone
        p_value = min(1.0, worst * counts.shape[1])
        said = f"counts of zone {where} divided by {step} leave some remainders more often than others"
        out.append(Check(p_value, said))
    return out


def gap(counts: np.ndarray, mean: np.ndarray) -> Check:
    """Whether a zone holds no cell of a few counts, below the least that any has, where there should be some.

    A sensor may send small counts as none. That not one of cells of means μ holds 1 to m - 1 counts has the chance
    Π (1 - P(1 ≤ n < m)).
    """
    worst, sentence, zones = 1.0, "", counts.shape[1]
    for zone in range(zones):
        seen, due = counts[:, zone], mean[:, zone]
        least = min(seen[seen > 0], default=0)
        if least < 2:
            continue
        within = poisson.cdf(least - 1, due) - np.exp(-due)
        p = float(np.exp(np.log1p(-np.minimum(within, 1 - 1e-16)).sum()))
        if p < worst:
            worst, some = p, "1 count" if least == 2 else f"1 to {least - 1:.0f} counts"
            sentence = f"no cell of a zone holds {some}, where {within.sum():.0f} should"
    return Check(min(1.0, worst * zones), sentence, foreign=True, certain=True)


def _not_recurring(counts: np.ndarray, step: int) -> np.ndarray:
    """Counts (N,) without those of the commonest that are more than there are of either next with its remainder."""
    often = np.bincount(counts)
    commonest = int(often.argmax())
    beside = [often[at] for at in (commonest - step, commonest + step) if 0 <= at < len(often)]
    spare = often[commonest] - RECURRING * max(beside, default=0)
    if spare < FEW:
        return counts
    kept = counts[counts != commonest]
    return np.concatenate([kept, np.full(max(beside, default=0), commonest)])

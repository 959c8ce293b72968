"""An effect beside those already chosen: fitted on some frames, judged on others."""

from dataclasses import dataclass

import numpy as np
from scipy.stats import norm

from mismatch.cost import cost, least_cost
from mismatch.fit import Fit, begin_beside, expected_at, reached
from mismatch.form import Form
from mismatch.gained import SIGNIFICANT, falls_short, gained, poisson_scatter
from mismatch.head_start import begun
from mismatch.poisson import LEAST
from mismatch.race import race
from mismatch.score import Score
from mismatch.simulation import Simulation

# A second effect that gains less deviance than this on held-out frames, or than this part of what the others gained,
# is no name: two formulas of one cause differ by as much.
MINOR, MINOR_PART = 60.0, 0.08
# One that gains what it should if it were the cause needs less: what stands in for another formula falls short of that.
MINOR_AS_EXPECTED = 35.0
# A third is less likely beforehand than that a formula of two is somewhat off: it needs more, as it is expected or not,
# and where they act the whole of that part.
A_THIRD = 100.0
# The more it gains the better it can be told whether that is what it should: from so much on a quarter of that part is
# enough, less than that the less a minor one gains. From so much on it can be told to a tenth, and an eighth is.
TOLD, WELL_TOLD = 100.0, 500.0
# Standard deviations by which a true cause may gain less than it should: one of six does by the first, one of 20 by the
# second, which is enough where no other formula of what was found acts, and one of 160 by the last.
NEAR, NEAR_ELSEWHERE, FAR = 1.0, 1.65, 2.5
# And more, where it looks: the frames that chose tell as badly as others how often things are there, which are few, and
# their gains far from normal.
FEW = 4.0
# What should gain less than this part of what it gains is not the cause, where that is beyond noise.
SURPRISING = 0.5
# Nor need it gain any part of what others did where so much of its change is in cells that it changes by more than
# they do: another formula of theirs would not.
ELSEWHERE = 0.8
# One that gains less deviance than this on held-out frames has come to nothing, however well its trace fits them.
NOTICEABLE = 5.0


@dataclass(frozen=True, eq=False)
class Candidate:
    """An effect beside those already chosen, fitted.

    score: what it promised. fit: of the frames that choose. criterion: deviance there, and the price of its parameters
    (Schwarz 1978). heldout: deviance on the frames that decide. z: how many standard deviations the change it makes
    stands out of the noise of those frames.
    observed, expected_gain, scatter: what deviance it gains there, what it should if it were the cause, and the
    standard deviation of that. elsewhere: part of its change that is in cells which it changes by more than the effects
    before it do.
    """

    score: Score
    fit: Fit
    criterion: float
    heldout: float
    z: float
    observed: float
    expected_gain: float
    scatter: float
    elsewhere: float

    @property
    def form(self) -> Form:
        """Its form."""
        return self.score.form

    @property
    def looks(self) -> bool:
        """Whether it looks where things are in each frame."""
        setting = self.fit.settings[-1]
        return setting.effect.looks(setting.values)

    def stands_out(self, many: int) -> bool:
        """Whether it is more than noise on the frames that decide, one of so many candidates.

        One that looks where things are in each frame follows whatever stands out; not what it should be if it falls
        far short.
        """
        if self.looks and self.falls_short:
            return False
        return bool(norm.sf(self.z) * many < SIGNIFICANT and self.observed > NOTICEABLE)

    @property
    def falls_short(self) -> bool:
        """Whether it gains less than half of what it should if it were the cause, beyond noise."""
        return falls_short(self.observed, self.expected_gain, self.scatter, True)

    def is_minor(self, won: float, others: int = 1) -> bool:
        """Whether it gains too little to be a cause of its own beside so many others, which gained `won`.

        The gain of a true cause scatters about what is expected. What gains far more than that has found the place, but
        not the cause; unless frames that chose happened to show things at worse places, or fewer of them.
        """
        # What is expected was told by frames as many, and scatters about what it should be as what is gained does.
        short = (self.expected_gain - self.observed) / (np.sqrt(2) * self.scatter)
        both = max(poisson_scatter(self.expected_gain + self.observed), self.scatter)
        far = short < -FEW if self.looks else self.observed - self.expected_gain > FAR * both
        if far and self.expected_gain < SURPRISING * self.observed:
            return True
        if others > 1 and self.observed < max(A_THIRD, MINOR_PART * won if self.elsewhere <= ELSEWHERE else 0.0):
            return True
        least = MINOR_AS_EXPECTED if short < (NEAR_ELSEWHERE if self.elsewhere > ELSEWHERE else NEAR) else MINOR
        told = np.log(max(self.observed, MINOR) / MINOR) / np.log(TOLD / MINOR) if short < FAR else 0.0
        part = MINOR_PART / 4 ** min(told, 1.0)
        part = MINOR_PART / 8 if short < NEAR and self.observed > WELL_TOLD else part
        return self.observed < (least if self.elsewhere > ELSEWHERE else max(least, part * won))


def candidates_of(
    train: Simulation, test: Simulation, before: Fit, chosen: list[Score], least: float = np.inf
) -> list[Candidate]:
    """Forms beside those of a fit, fitted on some frames and judged on others, best first.

    least: criterion of another that stands out, which they are to come near.

    Those that cannot come near the best are not fitted to the end, unless none of the others stands out. The best of
    each effect that comes near is fitted as its other way has it, too: what scores promise far from where they are true
    may be off by more than such ways differ.
    """

    def judged(i: int) -> Candidate:
        return candidate(train, test, before, chosen[i], reached(descents[i]))

    if not chosen:
        return []
    begin_beside(test, before)
    prices = [least_cost(train, (*before.forms, found.form)) for found in chosen]
    descents = begun(train, before, chosen, prices)
    left = race(descents, prices, least)
    came_to = [descent.deviance + a for descent, a in zip(descents, prices, strict=True)]
    firsts = [] if train.work.enough else _first_of_each(chosen, came_to)
    near = [i for i in firsts if i not in left and chosen[i].other is not None]
    others = [chosen[i].other for i in near]
    theirs = [prices[i] for i in near]
    began = begun(train, before, others, theirs)
    left += [len(chosen) + i for i in race(began, theirs, min(*came_to, least))]
    chosen, descents = [*chosen, *others], [*descents, *began]
    made = train.each(judged, range(len(chosen)))
    if (
        left
        and least == np.inf
        and not train.work.enough
        and not any(made[i].stands_out(len(chosen)) for i in range(len(chosen)) if i not in left)
    ):
        train.each(lambda i: descents[i].run(), left)
        made = train.each(judged, range(len(chosen)))
    return sorted(made, key=lambda c: c.criterion)


def _first_of_each(chosen: list[Score], came_to: list[float]) -> list[int]:
    """Which form of each effect came to least."""
    first: dict[str, int] = {}
    for i in sorted(range(len(chosen)), key=came_to.__getitem__):
        first.setdefault(chosen[i].form.effect.id, i)
    return list(first.values())


def candidate(train: Simulation, test: Simulation, before: Fit, found: Score, fitted: Fit) -> Candidate:
    """A form that was fitted beside those of a fit, judged on other frames."""
    won = gained(test, before, fitted)
    criterion = fitted.deviance + cost(train, fitted)
    away = elsewhere(test, before, fitted) if before.forms else 1.0
    return Candidate(found, fitted, criterion, won.deviance, won.z, won.observed, won.expected, won.scatter, away)


def elsewhere(test: Simulation, before: Fit, fitted: Fit) -> float:
    """Part of the last effect's change, by deviance, in cells that it changes by more than those before it do."""
    now, then = (expected_at(test, one.forms, one.x) for one in (before, fitted))
    theirs = np.abs(now - test.expected(before.gain))
    its = np.abs(then - test.expected(fitted.gain, fitted.settings[:-1]))
    size = its**2 / np.maximum(now, LEAST)
    return float(size[its > theirs].sum() / max(size.sum(), LEAST))

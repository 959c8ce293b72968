"""Which of what forms promise is fitted: the effects that promise most, and all ways of those that come near."""

import numpy as np

from mismatch.candidates import Candidate, candidates_of
from mismatch.fit import Fit
from mismatch.form import Form
from mismatch.poisson import expected_deviance
from mismatch.race import BEYOND, BEYOND_PART
from mismatch.score import Score
from mismatch.simulation import Simulation

# Standard deviations by which noise may leave more to be gained.
SCATTER = 3.0
# So many effects are fitted in full; what ranks lower by the score test is left, unless it promises nearly as much as
# any does.
FITTED, CLOSE = 6, 0.75
# Where none of them stands out the next are fitted, until so many forms were.
MOST_FITTED = 12
# Ways in which one effect is fitted; and part of the numbers of a form that another has which is plainer.
MOST_WAYS, FEWER = 4, 0.5
# Forms that promise less than this part of the most that any promises are left.
PROMISING = 0.3


def candidates_among(
    train: Simulation, test: Simulation, before: Fit, scores: list[Score], many: int = 0
) -> list[Candidate]:
    """The most promising of forms beside those of a fit, fitted and judged, best first.

    Where one of them stands out so are the other ways of what comes near. many: how many forms were fitted before.
    """
    found = candidates_of(train, test, before, most_promising(scores, to_be_gained(before)))
    if not train.work.enough and any(c.stands_out(many + len(found)) for c in found):
        found += candidates_of(train, test, before, other_ways(before, scores, found), found[0].criterion)
    return sorted(found, key=lambda c: c.criterion)


def most_promising(scores: list[Score], most: float = np.inf) -> list[Score]:
    """For each of the effects that promise most two of its forms that promise most; and of its forms that look, too.

    And one of the same value in all zones, where these have a value for each, or of far fewer numbers, as what goes
    straight where these are curved: it promises less, and costs less. And one in each other way of being there, of
    other strengths: what they promise where they begin tells little of where they end.

    most: deviance that there is to be gained, which scores far from where they are true surpass, most of all where
    few counts are expected. Forms that look do not: what they promise they have gained.
    """
    effects: list[str] = []
    chosen = []
    best = min(max((s.beyond_noise for s in scores), default=0.0), most)
    for s in scores:
        if s.beyond_noise < PROMISING * best:
            continue
        name = s.form.effect.id
        if name not in effects:
            if len(effects) >= (MOST_FITTED if s.beyond_noise > CLOSE * best else FITTED):
                continue
            effects.append(name)
        alike = [c.form for c in chosen if c.form.effect.id == name and c.form.looks == s.form.looks]
        same = [form for form in alike if form.strengths == s.form.strengths]
        plain = same and not s.form.own and all(form.own for form in same)
        another = not same and len(alike) < MOST_WAYS
        plain = plain or (s.beyond_noise > CLOSE * best and bool(same) and _has_fewer(s.form, same))
        if len(alike) < 2 or plain or another:
            chosen.append(s)
    return chosen


def _has_fewer(form: Form, others: list[Form]) -> bool:
    """Whether it has far fewer numbers than any of others, or far fewer parameters: each zone may have its own."""
    counts = (lambda one: len(one.coordinates)), (lambda one: len(one.free))
    return any(count(form) <= FEWER * min(map(count, others)) for count in counts)


def other_ways(before: Fit, scores: list[Score], found: list[Candidate]) -> list[Score]:
    """Ways of being there that were not fitted, with one value for all zones, of effects that came near the best.

    What promises less may end nearer, and which effect is the best is a matter of the best way of each. The others of
    the best itself are tried once it is chosen.
    """
    best = found[0]
    near = best.criterion + max(BEYOND, BEYOND_PART * (before.deviance - best.criterion))
    effects = {c.form.effect.id for c in found if c.criterion < near} - {best.form.effect.id}
    fitted = {(c.form.effect.id, c.form.free) for c in found}
    ways: dict[tuple, Score] = {}
    for s in scores:
        key = (s.form.effect.id, s.form.free)
        if s.form.effect.id in effects and not s.form.own and key not in fitted:
            ways.setdefault(key, s)
    return list(ways.values())


def to_be_gained(fitted: Fit) -> float:
    """Deviance of a fit beyond what noise makes, and as much more as that may scatter."""
    mean, variance = (float(of.sum()) for of in expected_deviance(fitted.expected))
    return max(fitted.deviance - mean, 0.0) + SCATTER * np.sqrt(variance)

"""Which effects: forward selection on some frames, decided on others."""

from dataclasses import dataclass, replace

import numpy as np

from mismatch.candidates import Candidate
from mismatch.cost import cost, numbers_cost
from mismatch.descent import MOST_STEPS
from mismatch.fit import Fit, expected_at, fit, fit_nominal
from mismatch.fluctuation import frame_gain_sigma
from mismatch.form import Form
from mismatch.gained import SIGNIFICANT
from mismatch.leftover import what_is_left
from mismatch.promising import MOST_FITTED, candidates_among
from mismatch.race import BEYOND
from mismatch.ranking import ranked
from mismatch.refined import refined
from mismatch.score import Score
from mismatch.simulation import Simulation

MOST_EFFECTS = 3
# Of what an effect gains that anybody would write in the same way, so much counts as what may leave traces of it; and
# no more than this deviance: zones exchanged may gain a million.
EXACT, MOST_EXACT = 0.25, 1000.0


@dataclass(frozen=True, eq=False)
class Round:
    """One step of the selection.

    before: what was fitted. scores: what forms promise beside it, best first. tried: how many forms there were.
    candidates: those that were fitted, best first by criterion. chosen: the one that was added, None where none was.
    minor: one that was not added because it gains too little beside others to be a cause of its own.
    """

    before: Fit
    scores: tuple[Score, ...]
    tried: int
    candidates: tuple[Candidate, ...]
    chosen: Candidate | None
    minor: Candidate | None = None


def select(train: Simulation, test: Simulation, forms: list[Form]) -> list[Round]:
    """Add one effect at a time while the frames held out agree; drop what another makes superfluous."""
    now = fit_nominal(train)
    return onward(train, test, forms, [], fit_nominal(train, fluctuation(train, now)))


def begun_with(
    train: Simulation, test: Simulation, forms: list[Form], first: Round, candidate: Candidate, richer: bool = True
) -> list[Round]:
    """The same from the first round on, had it chosen another of its candidates.

    richer: whether that may take a richer form before others are sought beside it.
    """
    now = refreshed(train, refined(train, test, candidate.fit, forms) if richer else candidate.fit)
    return onward(train, test, forms, [replace(first, chosen=candidate)], now)


def onward(train: Simulation, test: Simulation, forms: list[Form], rounds: list[Round], now: Fit) -> list[Round]:
    """Rounds so far, and those that follow from a fit where they led."""
    while len(rounds) < MOST_EFFECTS and not train.work.enough:
        scores, tried = ranked(train, now, others_than(now, forms))
        significant = [s for s in scores if s.log_p < np.log(SIGNIFICANT / tried)]
        candidates: list[Candidate] = []
        best: Candidate | None = None
        while significant and (best is None or best.falls_short) and len(candidates) < MOST_FITTED:
            found = candidates_among(train, test, now, significant, len(candidates))
            candidates = sorted((*candidates, *found), key=lambda c: c.criterion)
            best = next((c for c in candidates if c.stands_out(len(candidates))), None)
            # A score far from where it is true promises what no fit keeps, and hides what others promise. So does what
            # gains on other frames next to nothing of what it should.
            fitted = {c.form.effect.id for c in found}
            significant = [s for s in significant if s.form.effect.id not in fitted]
            if train.work.enough:
                break
        won = sum(_leaving(one.chosen) for one in rounds if one.chosen is not None)
        minor = best is not None and bool(now.forms) and best.is_minor(won, len(now.forms))
        if minor or (best is not None and now.forms and best.criterion > now.deviance + cost(train, now)):
            return [*rounds, Round(now, tuple(scores), tried, tuple(candidates), None, best)]
        rounds = [*rounds, Round(now, tuple(scores), tried, tuple(candidates), best)]
        if best is None:
            return rounds
        now = refreshed(train, _likeliest_way(train, test, forms, best, candidates))
    scores, tried = ranked(train, now, others_than(now, forms))
    return [*rounds, Round(now, tuple(scores), tried, (), None)]


def _likeliest_way(
    train: Simulation, test: Simulation, forms: list[Form], best: Candidate, candidates: list[Candidate]
) -> Fit:
    """The fit of a candidate as it is refined; or of another way of its effect that came near, where that is likelier.

    That is one number for all in place of a number for each zone, or what is strong there is another, where something
    is left: with more said of how it is there it may be the likelier, which no richer form of the first says.
    """
    found = refined(train, test, without_superfluous(train, best.fit), forms)
    alike = [c for c in candidates if c.form.effect is best.form.effect and not c.form.own]
    others = [c for c in alike if best.form.own or c.form.strengths != best.form.strengths]
    ways: dict[tuple[str, ...], Candidate] = {}
    for other in sorted(others, key=lambda c: c.criterion):
        if other.criterion < best.criterion + BEYOND:
            ways.setdefault(other.form.strengths, other)
    if not ways or (not best.form.own and not what_is_left(train, found)):
        return found
    refine = (refined(train, test, without_superfluous(train, other.fit), forms) for other in ways.values())
    return min(found, *refine, key=lambda one: one.deviance + cost(train, one))


def _leaving(chosen: Candidate) -> float:
    """Deviance that an effect gained, as far as another formula of it may have left parts of that."""
    return min(EXACT * chosen.observed, MOST_EXACT) if chosen.form.effect.exact else chosen.observed


def others_than(fitted: Fit, forms: list[Form]) -> list[Form]:
    """Forms of effects that are not in a fit."""
    taken = {form.effect.id for form in fitted.forms}
    return [form for form in forms if form.effect.id not in taken]


def without(simulation: Simulation, fitted: Fit, form: Form, most_steps: int = MOST_STEPS) -> Fit:
    """The fit less one effect, fitted anew."""
    kept = tuple(other for other in fitted.forms if other is not form)
    x = np.concatenate([fitted.x[:1], *(coordinates(fitted, other) for other in kept)])
    return fit(simulation, kept, x, fitted.frame_gain_sigma, most_steps=most_steps)


def without_superfluous(train: Simulation, fitted: Fit) -> Fit:
    """The fit less every earlier effect whose absence costs less than its parameters' price."""
    for form in fitted.forms[:-1]:
        less = without(train, fitted, form)
        patterns = 0.0 if fitted.pattern is None else fitted.pattern.cost
        patterns -= 0.0 if less.pattern is None else less.pattern.cost
        numbers = numbers_cost(train, fitted) - numbers_cost(train, less)
        if less.deviance - fitted.deviance < numbers + patterns:
            return without_superfluous(train, less)
    return fitted


def coordinates(fitted: Fit, form: Form) -> np.ndarray:
    """Those of one form in a fit."""
    at = 1
    for other in fitted.forms:
        count = len(other.coordinates)
        if other is form:
            return fitted.x[at : at + count]
        at += count
    raise ValueError(form.name)


def refreshed(train: Simulation, fitted: Fit) -> Fit:
    """The fit with the frames' fluctuation that is left beside its effects."""
    sigma = fluctuation(train, fitted)
    if sigma == fitted.frame_gain_sigma:
        return fitted
    return fit(train, fitted.forms, fitted.x, sigma)


def fluctuation(train: Simulation, fitted: Fit) -> float:
    """How much gain fluctuates from frame to frame beside a fit: of all frames, as of some few are successive."""
    every = train if train.whole is None else train.whole
    return frame_gain_sigma(every, expected_at(every, fitted.forms, fitted.x))

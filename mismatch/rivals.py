"""Look-alikes: other effects in the place of one that was chosen, and how probable each is."""

from dataclasses import dataclass

import numpy as np

from mismatch.candidates import Candidate
from mismatch.cost import cost, strain
from mismatch.fit import Fit, fit
from mismatch.form import Form
from mismatch.growing import grown
from mismatch.onset import set_in
from mismatch.refined import each_richer, enriched
from mismatch.score import start_of
from mismatch.selection import Round, coordinates
from mismatch.simulation import Simulation
from mismatch.unseen import marginal_deviance
from recordings.refusal import Refusal

# Rivals that are worse by more deviance than this, and by more than this part of what the best gains, are not worth a
# fit: their richer forms, or effects that came beside it later, may make up for less. So many effects are tried.
CLOSE, CLOSE_PART, TRIED = 60.0, 0.2, 4
# What is less probable the data do tell apart.
LEAST_PROBABILITY = 0.05
# A name that is stretched does not win because of it, yet words may be used so: once in sixteen where it fits as well.
STRETCHED = 2 * np.log(16)


@dataclass(frozen=True, eq=False)
class Rival:
    """An effect in the place of another. fit: of the frames that choose. evidence: twice the logarithm of the
    probability of all frames, up to a constant: those that choose by Schwarz's criterion, those held out as predicted.
    strain: what of it is charged for names that are stretched.
    """

    form: Form
    fit: Fit
    evidence: float
    strain: float = 0.0


def evidence(train: Simulation, test: Simulation, fitted: Fit) -> float:
    """Twice the log-probability of both halves of the frames, up to a constant."""
    return -(sum(marginal_deviance(part, fitted) for part in (train, test)) + cost(train, fitted))


def rivals(
    train: Simulation, test: Simulation, now: Fit, form: Form, rounds: list[Round], forms: list[Form]
) -> list[Rival]:
    """The effect of `form` in a fit, and those that may stand in its place, the likeliest first.

    forms: all that effects may have.
    """
    found = [_rival(train, test, form, now)]
    others = [other for other in now.forms if other is not form]
    taken = {other.effect.id for other in others}

    def swapped(candidate: Candidate) -> Fit | None:
        if not others and candidate.fit.frame_gain_sigma == now.frame_gain_sigma:
            return candidate.fit  # There is nothing else it was fitted without.
        x = np.concatenate([now.x[:1], *(coordinates(now, other) for other in others), _start(candidate)])
        try:
            return fit(train, (*others, candidate.form), x, now.frame_gain_sigma)
        except Refusal:
            return None

    def as_late(fitted: Fit) -> Fit:
        # What stands in the place of an effect that sets in may set in as well.
        return set_in(train, test, fitted) if "since" in form.given else fitted

    close = [c for c in _close(rounds, form) if c.form.effect.id not in taken and c.form is not form]
    if train.work.far_beyond:
        close = list({c.form.effect.id: c for c in reversed(close)}.values())  # The best of each.
    fits = [as_late(fitted) for fitted in train.each(swapped, close) if fitted is not None]
    # One by one: what a cause leaves uncertain may take longer than all else, and works on all cores by itself.
    found += [_rival(train, test, fitted.forms[-1], fitted) for fitted in fits]
    beaten = [rival for rival in _best_of_each(found) if rival is not found[0]]
    if not train.work.enough:
        beaten = [_richer(train, test, one, forms) for rival in beaten for one in begun_from(rival, found)]
    # Another form of the one that was chosen may be the likelier, and is no look-alike of it.
    ranked = _best_of_each([*found, *beaten])
    if ranked[0].form.effect is form.effect or train.work.enough:
        return ranked
    # It was tried in richer forms where it left something; what beats it was tried in any case.
    x = np.concatenate([now.x[:1], *(coordinates(now, other) for other in (*others, form))])
    same = _rival(train, test, form, fit(train, (*others, form), x, now.frame_gain_sigma))
    alike = [_richer(train, test, one, forms) for one in begun_from(same, found)]
    return _best_of_each([*found, *beaten, *alike])


def _best_of_each(found: list[Rival]) -> list[Rival]:
    """The most probable of each effect, that with the most evidence first."""
    best: dict[str, Rival] = {}
    first = max(found, key=lambda rival: rival.evidence)
    for rival in (first, *sorted(found, key=lambda rival: -_log_odds(rival, first))):
        best.setdefault(rival.form.effect.id, rival)
    return list(best.values())


def begun_from(rival: Rival, found: list[Rival]) -> list[Rival]:
    """Forms of a rival's effect that richer ones begin from: its own, and the plainest that comes near.

    What a richer one has, as a turn, leads away from others, as a move by pixels. And the best in each other way of
    being there that comes near: what makes one richer another has not.
    """
    alike = [one for one in found if one.form.effect is rival.form.effect and one.evidence > rival.evidence - CLOSE]
    plainest = min(alike, key=lambda one: len(one.form.coordinates))
    begun = [rival] if len(plainest.form.coordinates) == len(rival.form.coordinates) else [rival, plainest]
    for one in sorted(alike, key=lambda one: -one.evidence):
        if all(one.form.strengths != other.form.strengths for other in begun):
            begun.append(one)
    return begun


def _rival(train: Simulation, test: Simulation, form: Form, fitted: Fit) -> Rival:
    """A form in a fit, with its evidence."""
    return Rival(form, fitted, evidence(train, test, fitted), strain(train, fitted))


def _richer(train: Simulation, test: Simulation, rival: Rival, forms: list[Form]) -> Rival:
    """A rival in a richer form of its own, or growing, where that is likelier."""
    fits = (enriched(train, rival.fit, forms), grown(train, test, rival.fit))
    others = [_rival(train, test, fitted.forms[-1], fitted) for fitted in fits if fitted is not rival.fit]
    return max((rival, *others), key=lambda one: one.evidence)


def likelier_forms(train: Simulation, test: Simulation, judged: Fit, forms: list[Form]) -> list[Fit]:
    """Fits with the last effect in other, richer forms of its own that are likelier by all frames, the likeliest first.

    What frames that choose hardly see may pay on those held out.
    """
    least = evidence(train, test, judged)
    told = [(evidence(train, test, one), one) for one in each_richer(train, judged, forms)]
    return [one for won, one in sorted(told, key=lambda pair: -pair[0]) if won > least]


def _close(rounds: list[Round], form: Form) -> list[Candidate]:
    """Candidates of the round that chose a form that came close to it."""
    for one in rounds:
        # It may have taken a richer form since.
        if one.chosen is not None and one.chosen.form.effect.id == form.effect.id:
            ordered = sorted(one.candidates, key=lambda c: c.criterion + c.heldout)
            best = max(c.criterion + c.heldout for c in (ordered[0], one.chosen))
            near = best + max(CLOSE, CLOSE_PART * 2 * one.chosen.observed)
            effects = list(dict.fromkeys(c.form.effect.id for c in ordered))[: 1 + TRIED]
            return [c for c in ordered if c.criterion + c.heldout < near and c.form.effect.id in effects]
    return []


def _start(candidate: Candidate) -> np.ndarray:
    """Coordinates from which to fit a candidate again."""
    if candidate.form in candidate.fit.forms:
        return coordinates(candidate.fit, candidate.form)
    return start_of(candidate.form, candidate.score.amplitude)


def probabilities(found: list[Rival]) -> np.ndarray:
    """(N,) of each rival, the likeliest of which is the first, that one of them is the cause.

    All equally likely beforehand, but names that are more stretched than the first.
    """
    logs = np.array([_log_odds(one, found[0]) for one in found]) / 2
    chance = np.exp(logs - logs.max())
    return chance / chance.sum()


def _log_odds(one: Rival, first: Rival) -> float:
    """Twice the logarithm of the odds of a rival, up to a constant: what is more stretched than the first has some."""
    more = one.strain - first.strain
    return max(one.evidence, min(one.evidence + more, first.evidence - STRETCHED)) if more > 0 else one.evidence

"""An effect that was chosen before others, chosen anew beside them: it may have taken up parts of what they are."""

from dataclasses import replace

import numpy as np

from mismatch.absorbed import absorbed
from mismatch.candidates import Candidate, candidate, candidates_of
from mismatch.fit import Fit, fit
from mismatch.form import Form
from mismatch.gained import SIGNIFICANT
from mismatch.growing import grown
from mismatch.promising import candidates_among
from mismatch.ranking import ranked
from mismatch.refined import enriched
from mismatch.rivals import evidence
from mismatch.selection import MOST_EFFECTS, Round, coordinates, onward, others_than, without
from mismatch.simulation import Simulation

# Part of what an effect gains beside the others that another must promise to be fitted in its place.
PROMISING = 0.5
# Twice the logarithm of the odds at which it is exchanged.
ODDS = 10.0


def exchanged(
    train: Simulation, test: Simulation, forms: list[Form], rounds: list[Round], own: bool = False
) -> list[Round]:
    """Rounds in which each effect but the last, which was chosen beside the others in any case, is the likeliest there.

    And none of them is superfluous once another is let be richer. As they were, where that holds.

    own: whether the last was chosen among its own forms alone.
    """
    for _ in range(MOST_EFFECTS):
        found = rounds[-1].before
        less = absorbed(train, test, forms, found)
        if less is not found:
            there = {form.effect.id for form in less.forms}
            stay = [one for one in rounds if one.chosen is not None and one.chosen.form.effect.id in there]
            rounds, own = onward(train, test, forms, stay, less), False
        rounds, other = _one_exchanged(train, test, forms, rounds, own)
        own = False
        if not other:
            rounds, own = one_in_another_form(train, test, forms, rounds)
        if less is found and not (other or own):
            break
    return rounds


def _one_exchanged(
    train: Simulation, test: Simulation, forms: list[Form], rounds: list[Round], own: bool
) -> tuple[list[Round], bool]:
    """Rounds in which one effect, chosen beside all others, has taken the place of one that was chosen before them.

    Or of the last, where that was chosen among its `own` forms alone.

    And whether one has. Where none has, what may stand in the place of each was tried beside all others.
    """
    found = rounds[-1].before
    for form in found.forms if own and len(found.forms) > 1 else found.forms[:-1]:
        if train.work.enough:
            break
        other = _in_place_of(train, test, forms, found, form)
        if other is None:
            continue
        if not _likelier(train, test, other.chosen.fit, found):
            rounds = _beside_all(train, test, rounds, form, other)
            continue
        stay = [one for one in rounds if one.chosen is not None and one.chosen.form.effect is not form.effect]
        # What was exchanged is among those that may stand in the place of what it was exchanged for.
        was = [_chosen_last(train, test, found, one, other.before, form) for one in rounds if one not in stay]
        other = replace(other, candidates=(*other.candidates, *(one for one in was if one is not None)))
        return onward(train, test, forms, [*stay, other], other.chosen.fit), True
    return rounds, False


def one_in_another_form(
    train: Simulation, test: Simulation, forms: list[Form], rounds: list[Round]
) -> tuple[list[Round], bool]:
    """Rounds in which one of several effects has another form of its own, which is likelier beside the others.

    And whether one has. It was chosen among its forms before others had names, or for its promise.
    """
    found = rounds[-1].before
    for form in found.forms if len(found.forms) > 1 else ():
        if train.work.enough:
            break
        other = _in_place_of(train, test, forms, found, form, itself=True)
        if other is None or not _likelier(train, test, other.chosen.fit, found):
            continue
        fits = other.chosen.fit, enriched(train, other.chosen.fit, forms)
        stay = [one for one in rounds if one.chosen is not None and one.chosen.form.effect is not form.effect]
        rivals = [c for one in rounds if one not in stay for c in one.candidates if c.form.effect is not form.effect]
        other = replace(other, candidates=(*other.candidates, *rivals))
        return onward(train, test, forms, [*stay, other], max(fits, key=lambda f: evidence(train, test, f))), True
    return rounds, False


def _likelier(train: Simulation, test: Simulation, one: Fit, other: Fit) -> bool:
    """Whether a fit is so much likelier than another that it takes its place."""
    return evidence(train, test, one) >= evidence(train, test, other) + ODDS


def _beside_all(train: Simulation, test: Simulation, rounds: list[Round], form: Form, other: Round) -> list[Round]:
    """With the round in which others were tried in the place of an effect for that which chose it before the rest."""
    found = rounds[-1].before

    def anew(one: Round) -> Round:
        chosen = _chosen_last(train, test, found, one, other.before, form)
        return one if chosen is None else replace(other, candidates=(chosen, *other.candidates), chosen=chosen)

    return [anew(one) for one in rounds]


def _chosen_last(
    train: Simulation, test: Simulation, found: Fit, one: Round, before: Fit, form: Form
) -> Candidate | None:
    """An effect of a fit as if chosen after all others, which are in `before`; None if this round did not choose it."""
    if one.chosen is None or one.chosen.form.effect is not form.effect:
        return None
    order = (*(each for each in found.forms if each is not form), form)
    x = np.concatenate([found.x[:1], *(coordinates(found, each) for each in order)])
    here = fit(train, order, x, found.frame_gain_sigma, most_steps=0)
    return candidate(train, test, before, replace(one.chosen.score, form=form), here)


def _in_place_of(
    train: Simulation, test: Simulation, forms: list[Form], found: Fit, form: Form, itself: bool = False
) -> Round | None:
    """The round that chooses what is likeliest in the place of an effect that was found; None where nothing promises.

    itself: another form of it, and not another effect.
    """
    less = without(train, found, form)
    scores, tried = ranked(train, less, [f for f in others_than(less, forms) if (f.effect is form.effect) == itself])
    least = PROMISING * (less.deviance - found.deviance)
    promising = [s for s in scores if s.gain > least and s.log_p < np.log(SIGNIFICANT / tried)]
    if not promising:
        return None
    if itself:
        # What its forms promise where they begin tells them from others, and hardly from each other.
        each = {(s.form.free, s.form.own): s for s in reversed(promising)}
        candidates = candidates_of(train, test, less, list(each.values()))
    else:
        candidates = candidates_among(train, test, less, promising)
        candidates += _growing(train, test, less, candidates)
    likeliest = max(candidates, key=lambda candidate: evidence(train, test, candidate.fit))
    return Round(less, tuple(scores), tried, tuple(candidates), likeliest)


def _growing(train: Simulation, test: Simulation, before: Fit, candidates: list[Candidate]) -> list[Candidate]:
    """The best of each effect as it is where it grows in the course of the session, of those that are likelier so."""
    firsts = {c.form.effect.id: c for c in reversed(candidates)}.values()
    fits = [(c, grown(train, test, c.fit)) for c in firsts]
    return [candidate(train, test, before, replace(c.score, form=f.forms[-1]), f) for c, f in fits if f is not c.fit]

"""Names for what was found: each effect with its gain on held-out frames, its rivals, its parameters."""

from dataclasses import dataclass, replace

import numpy as np

from mismatch.beginnings import TWO_FOR_ONE
from mismatch.candidates import A_THIRD, MINOR, MINOR_AS_EXPECTED
from mismatch.capture import best_capture
from mismatch.coordinate import error_of, to_value
from mismatch.fit import Fit, on_others
from mismatch.form import Form
from mismatch.gained import gained
from mismatch.places import significance
from mismatch.rivals import LEAST_PROBABILITY, Rival, evidence, probabilities, rivals
from mismatch.selection import Round, without
from mismatch.simulation import Simulation
from mismatch.verdict import Alternative, Estimate, Named

# Part of what an effect gains on the frames that chose it that speaks for it beside what it gains on those held out.
CHOSEN_BY = 0.1
# One capture tells two causes apart when it gains this.
TELLING = 10.0


@dataclass(frozen=True, eq=False)
class Contest:
    """An effect in a fit and what may stand in its place. rivals: the likeliest first. chances: of each."""

    form: Form
    rivals: tuple[Rival, ...]
    chances: tuple[float, ...]


def contested(
    train: Simulation, test: Simulation, judged: Fit, rounds: list[Round], forms: list[Form]
) -> tuple[Fit, list[Contest]]:
    """The fit with the likeliest effect in each place, and the contest for each. forms: all that effects may have.

    What beats an effect by taking up what else was found, which was too little for a name, must be likelier than both.
    Where it is not both are named; or the first alone, where the other gains too little to be named beside anything.
    """
    contests, last = [], rounds[-1]
    for form in judged.forms:
        found = rivals(train, test, judged, form, rounds, forms)
        if found[0].form.effect is not form.effect and last.minor is not None and judged is last.before:
            both = last.minor.fit
            together = evidence(train, test, both) - TWO_FOR_ONE
            if together > found[0].evidence:
                if last.minor.observed >= MINOR:
                    told = [*rounds[:-1], replace(last, chosen=last.minor, minor=None)]
                    return contested(train, test, both, told, forms)
                own = next(rival for rival in found if rival.form.effect is form.effect)
                found = [replace(own, evidence=together), *(rival for rival in found if rival is not own)]
        judged = found[0].fit
        contests.append(_contest(found))
    judged = standing(train, test, judged)
    return judged, [contest for contest in contests if any(contest.form is form for form in judged.forms)]


def _contest(found: list[Rival]) -> Contest:
    """The contest that the first of these has won, the others by their chances."""
    chances = probabilities(found)
    order = np.argsort(-chances, kind="stable")
    return Contest(found[0].form, tuple(found[i] for i in order), tuple(chances[order]))


def standing(train: Simulation, test: Simulation, judged: Fit) -> Fit:
    """The fit less every effect without which frames held out fit nearly as well: others have come to say what it said.

    One that came first may have become too little to be a cause of its own, or to be one of three. It has not where few
    of the frames held out show it and the frames that chose miss it by much; but where those held out fit better
    without. The least of them goes first.
    """
    if len(judged.forms) < 2:
        return judged
    held, least = on_others(test, judged)[1], A_THIRD if len(judged.forms) > 2 else MINOR_AS_EXPECTED
    fits = [without(train, judged, form) for form in judged.forms]
    missed = [on_others(test, less)[1] - held for less in fits]
    worth = [
        -np.inf if lost < -MINOR_AS_EXPECTED else lost + CHOSEN_BY * (less.deviance - judged.deviance)
        for lost, less in zip(missed, fits, strict=True)
    ]
    at = int(np.argmin(worth))
    return standing(train, test, fits[at]) if worth[at] < least else judged


def name_effects(
    train: Simulation, test: Simulation, judged: Fit, contests: list[Contest], explained: Fit, tried: int
) -> tuple[Named, ...]:
    """Every effect of a fit, the one that gains most on held-out frames first; parameters from all frames."""
    named = [_name(train, test, judged, contest, explained, tried) for contest in contests]
    return tuple(sorted(named, key=lambda one: -one.heldout_gain))


def _name(train: Simulation, test: Simulation, judged: Fit, contest: Contest, explained: Fit, tried: int) -> Named:
    """One effect."""
    form = contest.form
    won = gained(test, without(train, judged, form), judged)
    texts = {look.id: look.separated_by for look in form.effect.look_alikes}
    others = [*zip(contest.rivals[1:], contest.chances[1:], strict=True)]
    alike = [(rival, chance) for rival, chance in others if chance >= LEAST_PROBABILITY]
    whole = contest.chances[0] + sum(chance for _, chance in alike)
    alternatives = []
    for rival, chance in alike:
        name = rival.form.effect.id
        told = texts.get(name) or _separation(train, contest.rivals[0], rival)
        alternatives.append(Alternative(name, float(chance / whole), told))
    return Named(
        id=form.effect.id,
        sentence=form.effect.sentence,
        parameters=estimates(explained, form),
        heldout_gain=won.observed,
        p_value=significance(won.z, tried),
        expected_gain=won.expected,
        scatter=won.scatter,
        look_alikes=tuple(alternatives),
    )


def estimates(fitted: Fit, form: Form) -> tuple[Estimate, ...]:
    """Parameters of one effect of a fit, in their units."""
    at = 1
    for other in fitted.forms:
        if other is form:
            break
        at += len(other.coordinates)
    out = []
    for i, (parameter, place) in enumerate(form.coordinates):
        value = to_value(parameter, fitted.x[at + i])
        sigma = float(np.sqrt(max(fitted.covariance[at + i, at + i], 0)))
        name = parameter.name if place is None else f"{parameter.name}[{place}]"
        out.append(Estimate(name, value, error_of(parameter, fitted.x[at + i], sigma), parameter.unit))
    for parameter in map(form.effect.parameter, form.given):
        values = np.atleast_1d(form.start[parameter.name])
        names = [parameter.name] if len(values) == 1 else [f"{parameter.name}[{place}]" for place in range(len(values))]
        out += [Estimate(name, float(v), 0.0, parameter.unit) for name, v in zip(names, values, strict=True)]
    return tuple(out)


def _separation(train: Simulation, one: Rival, other: Rival) -> str:
    """The capture that would tell, in a sentence."""
    capture, won = best_capture(train, one.fit, other.fit)
    return f"Record {capture.words}: the two would then differ by {won:.0f} in deviance."


def next_measurement(train: Simulation, contests: list[Contest]) -> str | None:
    """The capture that would tell the likeliest look-alikes apart; None where there are none."""
    close = [
        (c.chances[1], c.rivals[0], c.rivals[1])
        for c in contests
        if len(c.rivals) > 1 and c.chances[1] >= LEAST_PROBABILITY
    ]
    if not close:
        return None
    _, one, other = max(close, key=lambda entry: entry[0])
    capture, won = best_capture(train, one.fit, other.fit)
    names = f"{one.form.effect.id} and {other.form.effect.id}"
    if won < TELLING:
        return f"No capture that was simulated would tell {names} apart; record more frames."
    return f"Record {capture.words}: {names} would then differ by {won:.0f} in deviance over as many frames."

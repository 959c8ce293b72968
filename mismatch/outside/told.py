"""Whether a cause outside the library fits better than names of the library do."""

from collections.abc import Iterator

import numpy as np

from mismatch.cost import least_cost
from mismatch.descent import Descent
from mismatch.fit import Fit, fit_nominal, reached
from mismatch.form import Form, forms_of
from mismatch.leftover import NEGLIGIBLE, what_is_left
from mismatch.outside.causes import all_outside
from mismatch.places import Place, wherever
from mismatch.race import race
from mismatch.ranking import ranked
from mismatch.rivals import evidence
from mismatch.score import Score, start_of
from mismatch.selection import without
from mismatch.simulation import Simulation
from mismatch.unseen import marginal_deviance

# Twice the logarithm of the odds that a cause outside must have over the names it would replace: 20 to 1.
ODDS = 6.0
# One that promises less than this part of what the names gain cannot come near; so many are fitted, in so many forms.
PROMISING, FITTED, FORMS = 0.5, 4, 2


def told_outside(
    whole: Simulation, train: Simulation, test: Simulation, judged: Fit, *, beside: bool
) -> tuple[Place, ...]:
    """The cause outside the library that fits better than names of a fit do in their place; none, where none does.

    It is a misfit of the whole recording that has no place; its p-value is the odds of the names against it. beside:
    whether it may come beside all names as well.
    """
    mine, best, said = evidence(train, test, judged), ODDS, ""
    held = marginal_deviance(test, judged) + ODDS
    for replaced, less in _lessened(train, judged):
        if not (replaced or beside):
            continue
        for other in _outside(train, less, judged, beside):
            won = evidence(train, test, other) - mine
            # Numbers of zones pay each by itself, unless they are drawn, however alike they are: frames held out, which
            # ask no price, may keep such a name.
            paid = judged.pattern is None and any(form.own for form in replaced)
            if won > best and not (paid and marginal_deviance(test, other) > held):
                names = " and ".join(form.effect.id for form in replaced)
                stand = "stand" if len(replaced) > 1 else "stands"
                whose = f"{names} {stand} in for something else: it" if names else "what is left"
                verb = "fits better" if names else "is less"
                told = other.forms[-1].effect.sentence
                best, said = won, f"{whose} {verb}, by {won:.0f} in deviance, if {told}"
    return (wherever(whole, float(np.exp(-best / 2)), said),) if said else ()


def told_alone(train: Simulation, test: Simulation, judged: Fit) -> bool:
    """Whether a cause outside the library fits better by itself than all names of a fit, and leaves next to nothing."""
    least, nominal = evidence(train, test, judged) + ODDS, fit_nominal(train, judged.frame_gain_sigma)

    def leaves_little(other: Fit) -> bool:
        left = sum(place.gain for place in what_is_left(train, other))
        return left <= NEGLIGIBLE * (nominal.deviance - other.deviance)

    alone = _outside(train, nominal, judged, beside=True)
    return any(evidence(train, test, other) > least and leaves_little(other) for other in alone)


def _lessened(train: Simulation, judged: Fit) -> Iterator[tuple[tuple[Form, ...], Fit]]:
    """Names that may be replaced, and the fit without them: none, each, and all of several."""
    yield (), judged
    for form in judged.forms:
        yield (form,), without(train, judged, form)
    if len(judged.forms) > 1:
        yield judged.forms, fit_nominal(train, judged.frame_gain_sigma)


def _outside(train: Simulation, less: Fit, judged: Fit, beside: bool) -> list[Fit]:
    """Fits with a cause outside the library beside those of `less`.

    beside: whether something is left in any case. Where nothing is, one that can be mistaken for some names alone is
    not asked for where none of these was found.
    """
    sizes, named = {"zone": train.counts.shape[1], "bin": train.counts.shape[2]}, {f.effect.id for f in judged.forms}
    alike = [e for e in all_outside().values() if beside or not e.look_alikes or named & {o.id for o in e.look_alikes}]
    forms = [form for effect in alike for form in forms_of(effect, sizes)]
    scores, _ = ranked(train, less, forms)
    least = max(PROMISING * (less.deviance - judged.deviance), ODDS)
    best = _likeliest([score for score in scores if score.gain > least])
    best += [score.other for score in best if score.other is not None]

    def begun(found: Score) -> Descent:
        x = np.concatenate([less.x, start_of(found.form, found.amplitude)])
        return Descent(train, (*less.forms, found.form), x, judged.frame_gain_sigma)

    descents = train.each(begun, best)
    race(descents, [least_cost(train, descent.forms) for descent in descents])
    return [reached(descent) for descent in descents]


def _likeliest(scores: list[Score]) -> list[Score]:
    """The best forms of the best causes: those of one may be many and much alike."""
    of: dict[str, list[Score]] = {}
    for score in sorted(scores, key=lambda score: -score.gain):
        of.setdefault(score.form.effect.id, []).append(score)
    return [score for forms in list(of.values())[:FITTED] for score in forms[:FORMS]]

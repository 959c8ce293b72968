"""Chosen effects in other forms of their own, richer where something is left, plainer where another came beside."""

from collections.abc import Iterator

import numpy as np

from mismatch.cost import cost, least_cost
from mismatch.descent import Descent
from mismatch.fit import Fit, on_others, reached
from mismatch.form import Form
from mismatch.growing import grown, steady
from mismatch.leftover import what_is_left
from mismatch.onset import set_in
from mismatch.race import race
from mismatch.ranking import MOST_STRENGTHS
from mismatch.simulation import Simulation
from recordings.refusal import Refusal

MOST_TIMES = 2
# Deviance by which frames held out may fit worse: what is left free may show in others only, as at a session's ends.
INDIFFERENT = 0.5
# Steps after which it shows whether less will do.
SOON = 2


def refined(train: Simulation, test: Simulation, chosen: Fit, forms: list[Form]) -> Fit:
    """A fit with its last effect in the richest of its forms that earns its price, and fits frames held out as well.

    One that sets in in the course of the session is enriched from there on, one that grows as it grows. Each gives up
    what does not earn its price.
    """
    through_time = (chosen, set_in(train, test, chosen), grown(train, test, chosen))
    chosen = min(through_time, key=lambda one: one.deviance + cost(train, one))
    for _ in range(MOST_TIMES):
        # Numbers of all bins leave nothing, whatever fewer would do as well.
        if chosen.pattern is None and not what_is_left(train, chosen):
            break
        found = _best(train, chosen, list(richer(chosen.forms[-1], forms)))
        if found is None or found.deviance + cost(train, found) >= chosen.deviance + cost(train, chosen):
            break
        if on_others(test, found)[1] - on_others(test, chosen)[1] >= INDIFFERENT:
            break
        chosen = found
    return plainer(train, chosen, forms)


def enriched(train: Simulation, fitted: Fit, forms: list[Form]) -> Fit:
    """A fit with its last effect in the best of its richer forms, whether that earns its price or not."""
    return _best(train, fitted, list(richer(fitted.forms[-1], forms))) or fitted


def enlarged(train: Simulation, test: Simulation, chosen: Fit, forms: list[Form]) -> Iterator[Fit]:
    """Fits with the last effect in richer forms that leave frames held out better fitted.

    With a number for each zone, whether that earns its price or not, and the best of those that earn it.
    """
    form = chosen.forms[-1]
    own = tuple(n for n in form.strengths if form.effect.parameter(n).axis == "zone")
    zones = [form.with_own(own)] if own and not set(own) <= set(form.own) else []
    others = [other for other in richer(form, forms) if (other.free, other.own) != (form.free, own)]
    least = chosen.deviance + cost(train, chosen)
    for which, price in ((zones, np.inf), (others, least)):
        found = _best(train, chosen, which)
        if found is None or found.deviance + cost(train, found) >= price:
            continue
        if on_others(test, found)[1] < on_others(test, chosen)[1]:
            yield found


def each_richer(train: Simulation, fitted: Fit, forms: list[Form]) -> list[Fit]:
    """Fits with the last effect in each of its richer forms, whether that earns its price or not."""
    found = (_best(train, fitted, [form]) for form in richer(fitted.forms[-1], forms))
    return [one for one in found if one is not None]


def plainer(train: Simulation, fitted: Fit, forms: list[Form]) -> Fit:
    """A fit with its effects in forms with less in them, where that costs less than it saves.

    An earlier one may have had for want of the last what that says now; the last may have been tried with more alone.
    """
    now = fitted.deviance + cost(train, fitted)
    for at, form in enumerate(fitted.forms):
        # What the data said of the one, as when it set in, holds for the other.
        same = [*(o.given_as(form) for o in forms if o.effect.id == form.effect.id), steady(form)]
        less = {(o.free, o.own): o for o in same if _within(o, form)}
        for other in sorted(less.values(), key=lambda o: len(o.coordinates)):
            changed = (*fitted.forms[:at], other, *fitted.forms[at + 1 :])
            begins = [other.coordinates_from(form, fitted.settings[at])]
            before = 1 + sum(len(one.coordinates) for one in fitted.forms[:at])
            after = before + len(form.coordinates)
            x = np.concatenate([fitted.x[:before], *begins, fitted.x[after:]])
            descent = _begun(train, changed, x, fitted.frame_gain_sigma)
            if descent is None or descent.run(SOON).hoped + least_cost(train, changed) >= now:
                continue
            found = reached(descent.run())
            if found.deviance + cost(train, found) < now:
                return plainer(train, found, forms)
    return fitted


def _within(other: Form, form: Form) -> bool:
    """Whether a form has less in it than another: less that is free, or one number where zones have their own."""
    free, own = (set(of) for of in (other.free, other.own))
    if own == set(form.own) & free:
        return free < set(form.free)
    return free == set(form.free) and not own


def _begun(train: Simulation, forms: tuple[Form, ...], x: np.ndarray, sigma: float) -> Descent | None:
    """A fit that begins at x; None where counts cannot be as they would be there."""
    try:
        return Descent(train, forms, x, sigma)
    except Refusal:
        return None


def _best(train: Simulation, chosen: Fit, forms: list[Form]) -> Fit | None:
    """The best by Schwarz's criterion with the last effect in one of these forms, begun where it is."""
    begins = chosen.x[: -len(chosen.forms[-1].coordinates)]

    def begun(form: Form) -> Descent | None:
        x = np.concatenate([begins, form.coordinates_from(chosen.forms[-1], chosen.settings[-1])])
        return _begun(train, (*chosen.forms[:-1], form), x, chosen.frame_gain_sigma)

    descents = [descent for descent in train.each(begun, forms) if descent is not None]
    race(descents, [least_cost(train, descent.forms) for descent in descents])
    found = [reached(descent) for descent in descents]
    return min(found, key=lambda one: one.deviance + cost(train, one), default=None)


def richer(form: Form, forms: list[Form]) -> Iterator[Form]:
    """The form with a value for each zone instead of one for all, and forms that leave more, or other, free."""
    by_zone = tuple(name for name in form.free if form.effect.parameter(name).axis == "zone")
    for own in (tuple(name for name in by_zone if name in form.strengths), by_zone):
        if set(own) > set(form.own) and form.free not in form.effect.common:
            yield form.with_own(own)
    same = (other for other in forms if other.effect.id == form.effect.id)
    # Also those that leave something else free instead: this one may have been chosen for want of that.
    more = {(o.free, o.own): o.given_as(form) for o in same if _adds(o, form)}
    yield from more.values()


def _adds(other: Form, form: Form) -> bool:
    """Whether a form of the same strengths, or more, leaves something free that another does not.

    One of so many strengths that it is tried in no other way begins here whatever it has in common; of patches, too.
    """
    many = len(other.strengths) > MOST_STRENGTHS and other.free not in form.effect.richer
    many |= any(form.effect.parameter(name).axis == "patch" for name in set(other.own) - set(form.own))
    strengths = set(other.strengths) >= set(form.strengths) and set(other.own) >= set(form.own)
    return (strengths or many) and bool(set(other.free) - set(form.free))

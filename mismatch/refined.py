"""A chosen effect in richer forms of its own, where something is left: the name first, then what it is like."""

from collections.abc import Iterator

import numpy as np

from mismatch.candidates import cost
from mismatch.fit import Fit, fit, on_others
from mismatch.form import Form
from mismatch.leftover import what_is_left
from mismatch.simulation import Simulation
from recordings.refusal import Refusal

MOST_TIMES = 2


def refined(train: Simulation, test: Simulation, chosen: Fit, forms: list[Form]) -> Fit:
    """A fit with its last effect in the richest of its forms that earns its price, and fits frames held out better."""
    for _ in range(MOST_TIMES):
        if not what_is_left(train, chosen):
            break
        best, held = chosen, on_others(test, chosen)[1]
        for form in richer(chosen.forms[-1], forms):
            x = np.concatenate(
                [chosen.x[: -len(chosen.forms[-1].coordinates)], form.coordinates_of(chosen.settings[-1])]
            )
            try:
                found = fit(train, (*chosen.forms[:-1], form), x, chosen.frame_gain_sigma)
                earns = found.deviance + cost(train, found) < best.deviance + cost(train, best)
                if earns and on_others(test, found)[1] < held:
                    best = found
            except Refusal:
                continue
        if best is chosen:
            break
        chosen = best
    return chosen


def richer(form: Form, forms: list[Form]) -> Iterator[Form]:
    """The form with a value for each zone instead of one for all, and forms that leave more of the effect free."""
    by_zone = tuple(name for name in form.free if form.effect.parameter(name).axis == "zone")
    for own in (tuple(name for name in by_zone if name in form.strengths), by_zone):
        if set(own) > set(form.own):
            yield form.with_own(own)
    same = (other for other in forms if other.effect.id == form.effect.id)
    more = {(o.free, o.own): o for o in same if set(o.free) > set(form.free) and set(o.own) >= set(form.own)}
    for other in more.values():
        yield other.given_as(form)

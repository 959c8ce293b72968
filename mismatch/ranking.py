"""What every form of every effect promises beside a fit, cheaply: score tests, best first."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from mismatch.beside import Beside
from mismatch.cost import price
from mismatch.fit import Fit
from mismatch.form import Form
from mismatch.looked import looked
from mismatch.score import Score, changes_of, numbers_given, score_by
from mismatch.simulation import Simulation
from recordings.refusal import Refusal

# Forms of more strengths than this are tried only as richer ones of an effect that was chosen: each takes a rendering.
MOST_STRENGTHS = 6
# Chance that noise makes as much of some frames, by one of a form's starts, beyond which the others are not asked: of a
# cause that shows in all alike these have the quarter. Nor are they where it is less than this part of the most.
HOPELESS, LITTLE = 0.05, 0.15
# Logarithm of a chance by noise, as what is remembered tells it, beyond which nothing is looked at more closely: so
# many forms are tried that only one of thousands is significant.
KNOWN = -4.0
# Part of what the best start of a form promises that another of other given values must promise to be fitted, too.
NEARLY = 0.8


def ranked(simulation: Simulation, fitted: Fit, forms: list[Form]) -> tuple[list[Score], int]:
    """What forms promise beside a fit, the best start of each form, best first; and how many were tried.

    Some frames tell what is worth asking all; of what is not, what they promise themselves is told.
    """
    beside = Beside(simulation, fitted)
    # Fits beside this one begin with its slopes. Here, not where it was reached: there several are at once.
    simulation.remembered.slopes = fitted.slopes
    by_effect: dict[str, list[Form]] = {}
    for form in forms:
        if len(form.strengths) <= MOST_STRENGTHS and form.free not in form.effect.richer:
            by_effect.setdefault(form.effect.id, []).append(form)
    begun = simulation.each(lambda same: beginnings(beside, same), by_effect.values())
    first = beside.some or beside
    names = frozenset(form.effect.id for form in fitted.forms)
    known = first.simulation.remembered.beginning(first.fitted.expected, names)
    found = promises(first, begun, known)
    tried = len(found)
    if beside.some is not None:
        worth = _worth_asking(found)
        exact = promises(beside, [[form for form in same if form in worth] for same in begun])
        again, times = {_key(form) for form in worth}, beside.frames / beside.some.frames
        found = [replace(s, information=s.information * times) for s in found if _key(s.form) not in again] + exact
    each = price(simulation)
    return sorted((best_start(starts, each) for starts in _by_form(found).values()), key=lambda s: s.log_p), tried


def _key(form: Form) -> tuple:
    """Equal for the starts of one form."""
    return form.effect.id, form.free, form.own


def _by_form(scores: Iterable[Score]) -> dict[tuple, list[Score]]:
    """Those of each form's starts."""
    starts: dict[tuple, list[Score]] = {}
    for s in scores:
        starts.setdefault(_key(s.form), []).append(s)
    return starts


def _worth_asking(told: list[Score]) -> set[Form]:
    """Starts of those forms that promise something, as some frames tell it: that which does most, and what is near."""
    least = LITTLE * max((s.beyond_noise for s in told), default=0.0)
    worth = set()
    for starts in _by_form(told).values():
        best = max(starts, key=lambda s: s.gain)
        if best.log_p < np.log(HOPELESS / len(starts)) and best.beyond_noise > least:
            # What is gained scatters by twice its root.
            worth |= {s.form for s in starts if s.gain >= NEARLY * best.gain - 2 * np.sqrt(best.gain)}
    return worth


def beginnings(beside: Beside, same: list[Form]) -> list[Form]:
    """Forms of one effect as they begin, and begun where the data suggest; those that look, only where these do."""
    return [*(form for form in same if not form.looks), *suggested(beside.simulation, beside.fitted, same)]


def promises(beside: Beside, begun: Iterable[list[Form]], known: bool | None = None) -> list[Score]:
    """What forms of each effect promise. known: as `promise` takes it."""

    def of_effect(same: list[Form]) -> list[Score]:
        # Forms that begin alike promise alike, whatever else they leave free; but those that look pay for that.
        keys = [(form.begins_alike, form.free if form.looks else None) for form in same]
        once = {key: form for key, form in zip(keys, same, strict=True)}
        promised = {key: promise(beside, form, known) for key, form in once.items()}
        found = [(form, promised[key]) for form, key in zip(same, keys, strict=True)]
        return [replace(one, form=form) for form, one in found if one is not None]

    return [s for part in beside.simulation.each(of_effect, (same for same in begun if same)) for s in part]


def best_start(scores: list[Score], each: float = 0.0) -> Score:
    """Of one form's starts the one that promises most, and what the next does of other given values, if nearly that.

    each: deviance that a number must gain which the data gave.
    """

    def given(s: Score) -> tuple:
        return s.form.effect.at(**{name: v for name, v in s.form.start.items() if name not in s.form.free}).key

    def promised(s: Score) -> float:
        return s.gain - each * len(numbers_given(s.form))

    best = max(scores, key=promised)
    as_best = given(best)
    near = (s for s in scores if promised(s) > NEARLY * promised(best) and given(s) != as_best)
    return replace(best, other=max(near, key=promised, default=None))


def promise(beside: Beside, form: Form, known: bool | None = None) -> Score | None:
    """What one form promises; None where it can change nothing.

    known: whether what it changed beside an earlier fit tells enough, where by that it promises nothing; what it
    changes is remembered then. None where nothing is.
    """
    if form.looks:
        return looked(beside.simulation, beside.fitted, form)
    memory, key = beside.simulation.remembered, form.begins_alike
    if known and key in memory.changes:
        about = score_by(beside.projection, form, memory.changes[key])
        if about is None or about.log_p > KNOWN:
            return about

    def changes() -> np.ndarray:
        return changes_of(beside.simulation, beside.fitted, form)

    try:
        return score_by(beside.projection, form, changes() if known is None else memory.keep(key, changes))
    except Refusal:
        return None


def suggested(simulation: Simulation, fitted: Fit, forms: list[Form]) -> list[Form]:
    """Forms begun where the data suggest."""
    excess, rendering = simulation.counts - fitted.expected, simulation.rendering(fitted.gain, fitted.settings)
    once: dict[tuple, Form] = {}
    for form in forms:
        once.setdefault(_key(form), form)
    starts = {e.id: e.starts(excess, fitted.expected, rendering) for e in {f.effect for f in once.values()}}
    begun = (form.beginning(values) for form in once.values() for values in starts[form.effect.id])
    return [form for form in begun if form is not None]

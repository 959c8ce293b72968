"""What every form of every effect promises beside a fit, cheaply: score tests, best first."""

from dataclasses import replace

from mismatch.fit import Fit
from mismatch.form import Form
from mismatch.looked import looked
from mismatch.projection import Projection
from mismatch.score import Score, changes_of, score_by
from mismatch.simulation import Simulation
from recordings.refusal import Refusal

# Forms of more strengths than this are tried only as richer ones of an effect that was chosen: each takes a rendering.
MOST_STRENGTHS = 6
# Logarithm of a chance by noise, as far as can be told, beyond which nothing is looked at more closely: so many forms
# are tried that only one of thousands is significant.
HOPELESS = -4.0
# Part of what the best start of a form promises that another of other given values must promise to be fitted, too.
NEARLY = 0.8


def ranked(simulation: Simulation, fitted: Fit, forms: list[Form]) -> tuple[list[Score], int]:
    """What forms promise beside a fit, the best start of each form, best first; and how many were tried."""
    projection = Projection(simulation, fitted)
    known = simulation.remembered.beginning(fitted.expected)
    # Fits beside this one begin with its slopes. Here, not where it was reached: there several are at once.
    simulation.remembered.slopes = fitted.slopes
    by_effect: dict[str, list[Form]] = {}
    for form in forms:
        if len(form.strengths) <= MOST_STRENGTHS and form.free not in form.effect.richer:
            by_effect.setdefault(form.effect.id, []).append(form)

    def of_effect(same: list[Form]) -> list[Score]:
        # Where effects that look begin, only the data say.
        every = (*(form for form in same if not form.looks), *suggested(simulation, fitted, same))
        # Forms that begin alike promise alike, whatever else they leave free; but those that look pay for that.
        keys = [(form.begins_alike, form.free if form.looks else None) for form in every]
        once = {key: form for key, form in zip(keys, every, strict=True)}
        promised = {key: promise(simulation, fitted, projection, form, known) for key, form in once.items()}
        found = [(form, promised[key]) for form, key in zip(every, keys, strict=True)]
        return [replace(one, form=form) for form, one in found if one is not None]

    found = [s for part in simulation.each(of_effect, by_effect.values()) for s in part]
    starts: dict[tuple, list[Score]] = {}
    for s in found:
        starts.setdefault((s.form.effect.id, s.form.free, s.form.own), []).append(s)
    return sorted((best_start(of_form) for of_form in starts.values()), key=lambda s: s.log_p), len(found)


def best_start(scores: list[Score]) -> Score:
    """Of one form's starts the one that promises most, and what the next does of other given values, if nearly that."""

    def given(s: Score) -> tuple:
        return s.form.effect.at(**{name: v for name, v in s.form.start.items() if name not in s.form.free}).key

    best = max(scores, key=lambda s: s.gain)
    as_best = given(best)
    near = (s for s in scores if s.gain > NEARLY * best.gain and given(s) != as_best)
    return replace(best, other=max(near, key=lambda s: s.gain, default=None))


def promise(
    simulation: Simulation, fitted: Fit, projection: Projection, form: Form, known: bool = False
) -> Score | None:
    """What one form promises; None where it can change nothing.

    known: whether what it changed beside an earlier fit tells enough, where by that it promises nothing.
    """
    if form.looks:
        return looked(simulation, fitted, form)
    memory, key = simulation.remembered, form.begins_alike
    if known and key in memory.changes:
        about = score_by(projection, form, memory.changes[key])
        if about is None or about.log_p > HOPELESS:
            return about
    try:
        return score_by(projection, form, memory.keep(key, lambda: changes_of(simulation, fitted, form)))
    except Refusal:
        return None


def suggested(simulation: Simulation, fitted: Fit, forms: list[Form]) -> list[Form]:
    """Forms begun where the data suggest."""
    excess, rendering = simulation.counts - fitted.expected, simulation.rendering(fitted.gain, fitted.settings)
    once: dict[tuple, Form] = {}
    for form in forms:
        once.setdefault((form.effect.id, form.free, form.own), form)
    starts = {e.id: e.starts(excess, fitted.expected, rendering) for e in {f.effect for f in once.values()}}
    begun = (form.beginning(values) for form in once.values() for values in starts[form.effect.id])
    return [form for form in begun if form is not None]

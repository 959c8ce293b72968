"""What every form of every effect promises beside a fit, cheaply: score tests, best first."""

from dataclasses import replace

from mismatch.fit import Fit
from mismatch.form import Form
from mismatch.gained import to_be_gained
from mismatch.glance import glanced, promised
from mismatch.looked import looked
from mismatch.projection import Projection
from mismatch.score import Score
from mismatch.simulation import Simulation

# Forms of more strengths than this are tried only as richer ones of an effect that was chosen: each takes a rendering.
MOST_STRENGTHS = 6
# Frames of which half are enough to tell that a form promises nothing.
ENOUGH = 32


def ranked(simulation: Simulation, fitted: Fit, forms: list[Form]) -> tuple[list[Score], int]:
    """What forms promise beside a fit, the best start of each form, best first; and how many were tried."""
    by_effect: dict[str, list[Form]] = {}
    for form in forms:
        if len(form.strengths) <= MOST_STRENGTHS and form.free not in form.effect.richer:
            by_effect.setdefault(form.effect.id, []).append(form)

    def begun(same: list[Form]) -> list[Form]:
        # Where effects that look begin, only the data say.
        return [*(form for form in same if not form.looks), *suggested(simulation, fitted, same)]

    every = simulation.each(begun, by_effect.values())
    once = [{_key(form): form for form in same} for same in every]
    many = len(simulation.frames) >= ENOUGH
    glances = glanced(simulation, fitted, to_be_gained(fitted), once) if many else {}
    projection = Projection(simulation, fitted)
    known = simulation.remembered.beginning(fitted.expected)

    def of_effect(same: dict[tuple, Form]) -> dict[tuple, Score | None]:
        rest = {key: form for key, form in same.items() if key not in glances}
        return {
            key: looked(simulation, fitted, form)
            if form.looks
            else promised(simulation, fitted, known, projection, form)
            for key, form in rest.items()
        }

    told = glances | {key: one for part in simulation.each(of_effect, once) for key, one in part.items()}
    found = [replace(one, form=form) for same in every for form in same if (one := told[_key(form)]) is not None]
    best: dict[tuple, Score] = {}
    for s in found:
        key = (s.form.effect.id, s.form.free, s.form.own)
        if key not in best or s.gain > best[key].gain:
            best[key] = s
    return sorted(best.values(), key=lambda s: s.log_p), len(found)


def _key(form: Form) -> tuple:
    """Forms that begin alike promise alike, whatever else they leave free; but those that look pay for that."""
    return form.begins_alike, form.free if form.looks else None


def suggested(simulation: Simulation, fitted: Fit, forms: list[Form]) -> list[Form]:
    """Forms begun where the data suggest."""
    excess, rendering = simulation.counts - fitted.expected, simulation.rendering(fitted.gain, fitted.settings)
    once: dict[tuple, Form] = {}
    for form in forms:
        once.setdefault((form.effect.id, form.free, form.own), form)
    starts = {e.id: e.starts(excess, fitted.expected, rendering) for e in {f.effect for f in once.values()}}
    begun = (form.beginning(values) for form in once.values() for values in starts[form.effect.id])
    return [form for form in begun if form is not None]

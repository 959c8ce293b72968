"""What every form of every effect promises beside a fit, cheaply: score tests, best first."""

from dataclasses import replace

from mismatch.fit import Fit
from mismatch.form import Form
from mismatch.looked import looked, looks
from mismatch.projection import Projection
from mismatch.score import Score, score
from mismatch.simulation import Simulation

# Forms of more strengths than this are tried only as richer ones of an effect that was chosen: each takes a rendering.
MOST_STRENGTHS = 6


def ranked(simulation: Simulation, fitted: Fit, forms: list[Form]) -> tuple[list[Score], int]:
    """What forms promise beside a fit, the best start of each form, best first; and how many were tried."""
    projection = Projection(simulation, fitted)
    by_effect: dict[str, list[Form]] = {}
    for form in forms:
        if len(form.strengths) <= MOST_STRENGTHS and form.free not in form.effect.richer:
            by_effect.setdefault(form.effect.id, []).append(form)

    def of_effect(same: list[Form]) -> list[Score]:
        # Where effects that look begin, only the data say.
        every = (*(form for form in same if not looks(form)), *suggested(simulation, fitted, same))
        # Forms that begin alike promise alike, whatever else they leave free; but those that look pay for that.
        keys = [(form.begins_alike, form.free if looks(form) else None) for form in every]
        once = {key: form for key, form in zip(keys, every, strict=True)}
        promised = {key: promise(simulation, fitted, projection, form) for key, form in once.items()}
        found = [(form, promised[key]) for form, key in zip(every, keys, strict=True)]
        return [replace(one, form=form) for form, one in found if one is not None]

    found = [s for part in simulation.each(of_effect, by_effect.values()) for s in part]
    best: dict[tuple, Score] = {}
    for s in found:
        key = (s.form.effect.id, s.form.free, s.form.own)
        if key not in best or s.gain > best[key].gain:
            best[key] = s
    return sorted(best.values(), key=lambda s: s.log_p), len(found)


def promise(simulation: Simulation, fitted: Fit, projection: Projection, form: Form) -> Score | None:
    """What one form promises; None where it can change nothing."""
    return looked(simulation, fitted, form) if looks(form) else score(simulation, fitted, projection, form)


def suggested(simulation: Simulation, fitted: Fit, forms: list[Form]) -> list[Form]:
    """Forms begun where the data suggest."""
    excess, rendering = simulation.counts - fitted.expected, simulation.rendering(fitted.gain, fitted.settings)
    once: dict[tuple, Form] = {}
    for form in forms:
        once.setdefault((form.effect.id, form.free, form.own), form)
    starts = {e.id: e.starts(excess, fitted.expected, rendering) for e in {f.effect for f in once.values()}}
    begun = (form.beginning(values) for form in once.values() for values in starts[form.effect.id])
    return [form for form in begun if form is not None]

"""The report of an explanation: one HTML page that needs nothing else."""

from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, StrictUndefined
from markupsafe import Markup

from mismatch.explain import Explanation
from mismatch.selection import Round
from mismatch.verdict import Named, Verdict
from physics.effects import find_effect
from recordings.atomic import written_aside
from viewers import explain_figures as figures
from viewers.compared import Compared, bins_of_interest, compared, telling
from viewers.wording import chance, found_in_words, grouped, headline, number, plain_name, quantity

TEMPLATE = "report.html.jinja"
MOST_ZONES = 16  # whose sums over frames are drawn
LEAST_SCALE, MOST_SCALE = 4.0, 30.0  # of the residual maps, standard deviations


def write_report(explanation: Explanation, path: str | Path, name: str) -> None:
    """Write the page to `path`, whole or not at all; name: of the recording, as its reader knows it."""
    source = resources.files("viewers").joinpath(TEMPLATE).read_text(encoding="utf-8")
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.filters.update(plain=plain_name, number=number, chance=chance)
    page = environment.from_string(source).render(contents(explanation, name))
    with written_aside(path) as aside:
        aside.write_text(page, encoding="utf-8")


def contents(explanation: Explanation, name: str) -> dict[str, Any]:
    """What the page says, by the names that the template uses."""
    verdict, shown = explanation.verdict, compared(explanation)
    changed = bool(explanation.explained.forms)
    return {
        "name": name,
        "verdict": verdict,
        "headline": headline(verdict),
        "found": found_in_words(verdict),
        "changed": changed,
        "sizes": explanation.simulation.counts.shape,
        "frame_gain": explanation.explained.frame_gain_sigma,
        "effects": [_effect(effect) for effect in verdict.effects],
        "not_visible": _not_visible(verdict),
        "rounds": [_round(one) for one in explanation.rounds],
        "figures": _figures(explanation, shown, changed),
    }


def _effect(effect: Named) -> dict[str, Any]:
    """An effect with its numbers as text and what each is, and the probability that is left for itself."""
    parameters = [
        (
            plain_name(name),
            [(index, quantity(one.value, one.sigma, one.unit)) for index, one in values],
            find_effect(effect.id).parameter(name).sentence,
        )
        for name, values in grouped(effect.parameters)
    ]
    own = max(0.0, 1 - sum(other.probability for other in effect.look_alikes))
    return {"said": effect, "parameters": parameters, "probability": own}


def _not_visible(verdict: Verdict) -> list[tuple[str, str]]:
    """Effects that were not found, and the smallest strength that would have shown."""
    return [
        (
            one.id,
            quantity(one.smallest_visible, None, one.unit) if np.isfinite(one.smallest_visible) else "none would show",
        )
        for one in verdict.not_visible
    ]


def _round(one: Round) -> dict[str, Any]:
    """A step of the selection."""
    candidates = [(c.form, c.observed, c.expected_gain, c.z, c is one.chosen) for c in one.candidates]
    return {
        "before": [form.effect.id for form in one.before.forms],
        "tried": one.tried,
        "candidates": candidates,
        "chosen": None if one.chosen is None else one.chosen.form.effect.id,
    }


def _figures(explanation: Explanation, shown: Compared, changed: bool) -> dict[str, Any]:
    """The page's pictures as SVG elements; with no effect found there is no "after"."""
    verdict, width = explanation.verdict, explanation.simulation.clock.bin_width_s
    bins = bins_of_interest(shown)
    zones = shown.recorded.shape[1]
    told = shown.improvement if changed else shown.remaining
    drawn = np.sort(np.argsort(-told.sum(axis=0))[:MOST_ZONES])
    return {
        "places": [
            Markup(figures.histogram(shown, bins, zone, frame, width))
            for frame, zone in telling(shown, verdict.verdict)
        ],
        "sums": [Markup(figures.histogram(shown, bins, int(zone), None, width)) for zone in drawn],
        "zones_left_out": zones - len(drawn),
        "by_zone": _maps(shown, 0, bins, np.arange(zones), "zone", changed),
        "by_frame": _maps(shown, 1, bins, shown.frames, "frame", changed),
        "deviances": Markup(figures.deviances(verdict.train, verdict.heldout)),
        "deviance_by_frame": Markup(figures.deviance_by_frame(shown)),
    }


def _maps(shown: Compared, axis: int, bins: slice, rows: np.ndarray, ylabel: str, changed: bool) -> list[Markup]:
    """Residuals before and, where an effect was found, after, on one scale."""
    before, after = (values[:, bins] for values in shown.residuals(axis))
    scale = float(np.clip(np.quantile(np.abs([before, after]), 0.998), LEAST_SCALE, MOST_SCALE))
    titled = [("before", before), ("after", after)] if changed else [("recorded less simulated", before)]
    return [Markup(figures.residual_map(values, scale, title, ylabel, bins.start, rows)) for title, values in titled]

"""Look-alikes: other effects in the place of one that was chosen, and how probable each is."""

from dataclasses import dataclass

import numpy as np

from mismatch.candidates import Candidate, cost
from mismatch.fit import Fit, fit, on_others
from mismatch.form import Form
from mismatch.score import start_of
from mismatch.selection import Round, coordinates
from mismatch.simulation import Simulation
from recordings.refusal import Refusal

# Rivals that are worse by more deviance than this are not worth a fit.
CLOSE = 60.0
LEAST_PROBABILITY = 1e-3


@dataclass(frozen=True, eq=False)
class Rival:
    """An effect in the place of another. fit: of the frames that choose. evidence: twice the logarithm of the
    probability of all frames, up to a constant: those that choose by Schwarz's criterion, those held out as predicted.
    """

    form: Form
    fit: Fit
    evidence: float


def evidence(train: Simulation, test: Simulation, fitted: Fit) -> float:
    """Twice the log-probability of both halves of the frames, up to a constant."""
    return -(fitted.deviance + cost(train, fitted) + on_others(test, fitted)[1])


def rivals(train: Simulation, test: Simulation, now: Fit, form: Form, rounds: list[Round]) -> list[Rival]:
    """The effect of `form` in a fit, and those that may stand in its place, the likeliest first."""
    found = [Rival(form, now, evidence(train, test, now))]
    others = [other for other in now.forms if other is not form]
    taken = {other.effect.id for other in others}
    for candidate in _close(rounds, form):
        if candidate.form.effect.id in taken or candidate.form is form:
            continue
        x = np.concatenate(
            [now.x[:1], *(coordinates(now, other) for other in others), _start(candidate)],
        )
        try:
            swapped = fit(train, (*others, candidate.form), x, now.frame_gain_sigma)
        except Refusal:
            continue
        found.append(Rival(candidate.form, swapped, evidence(train, test, swapped)))
    best: dict[str, Rival] = {}
    for rival in found:
        name = rival.form.effect.id
        if name not in best or rival.evidence > best[name].evidence:
            best[name] = rival
    return sorted(best.values(), key=lambda rival: -rival.evidence)


def _close(rounds: list[Round], form: Form) -> list[Candidate]:
    """Candidates of the round that chose a form that came close to it."""
    for one in rounds:
        # It may have taken a richer form since.
        if one.chosen is not None and one.chosen.form.effect.id == form.effect.id:
            best = min(c.criterion + c.heldout for c in one.candidates)
            return [c for c in one.candidates if c.criterion + c.heldout < best + CLOSE]
    return []


def _start(candidate: Candidate) -> np.ndarray:
    """Coordinates from which to fit a candidate again."""
    if candidate.form in candidate.fit.forms:
        return coordinates(candidate.fit, candidate.form)
    return start_of(candidate.form, candidate.score.amplitude)


def probabilities(found: list[Rival]) -> np.ndarray:
    """(N,) of each rival, that one of them is the cause: all equally likely beforehand."""
    logs = np.array([rival.evidence for rival in found]) / 2
    chance = np.exp(logs - logs.max())
    return chance / chance.sum()

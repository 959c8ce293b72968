"""A glance at what forms promise: every second frame, which tells of most that they are not worth the rest."""

from collections.abc import Hashable
from dataclasses import replace

from mismatch.fit import Fit
from mismatch.form import Form
from mismatch.projection import Projection
from mismatch.score import Score, changes_of, log_chance, score_by
from mismatch.simulation import Simulation
from recordings.refusal import Refusal

# Logarithm of a chance by noise beyond which a form is not looked at with all frames. One that moves these by a
# deviance of 50 gets here once in a thousand times.
NOTHING = -2.0
# Part of the most that any form promises below which none is either: half of what is fitted at all.
FAINT = 0.15
# Logarithm of a chance, as far as all frames can tell beside an earlier fit, beyond which nothing is looked at more
# closely: so many forms are tried that only one of thousands is significant.
HOPELESS = -4.0


def promised(simulation: Simulation, fitted: Fit, known: bool, projection: Projection, form: Form) -> Score | None:
    """What a form promises that does not look; None where it can change nothing.

    known: whether what it changed beside an earlier fit tells enough, where by that it promises nothing.
    """
    memory, key = simulation.remembered, form.begins_alike
    if known and key in memory.changes:
        about = score_by(projection, form, memory.changes[key])
        if about is None or about.log_p > HOPELESS:
            return about
    try:
        return score_by(projection, form, memory.keep(key, lambda: changes_of(simulation, fitted, form)))
    except Refusal:
        return None


def glanced(
    simulation: Simulation, fitted: Fit, most: float, by_effect: list[dict[Hashable, Form]]
) -> dict[Hashable, Score]:
    """Of which forms every second frame tells enough, by key: about what each promises, of all frames.

    most: deviance that there is to be gained, in all frames.
    """
    few = simulation.sparse
    fitted = replace(fitted, simulation=few, expected=fitted.expected[::2])
    projection, known = Projection(few, fitted), few.remembered.beginning(fitted.expected)
    frames = len(simulation.frames) / len(few.frames)

    def of_effect(same: dict[Hashable, Form]) -> dict[Hashable, Score]:
        found = {key: promised(few, fitted, known, projection, form) for key, form in same.items() if not form.looks}
        return {key: _of_all(one, frames) for key, one in found.items() if one is not None}

    found = {key: one for part in simulation.each(of_effect, by_effect) for key, one in part.items()}
    least = FAINT * min(most, max((one.beyond_noise for one in found.values()), default=0.0))
    return {key: one for key, one in found.items() if one.log_p > NOTHING or one.beyond_noise < least}


def _of_all(score: Score, times: float) -> Score:
    """What so many times the frames would tell: more of what is there, and no more of what noise makes."""
    gain = max(times * score.beyond_noise + score.dof, 0.0)
    return replace(score, gain=gain, log_p=log_chance(gain, score.dof), information=times * score.information)

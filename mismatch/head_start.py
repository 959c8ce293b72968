"""Where fits of many frames begin: where some of the frames, which cost less, bring them."""

from collections.abc import Sequence

import numpy as np

from mismatch.beside import Beside
from mismatch.descent import Descent
from mismatch.fit import Fit
from mismatch.form import settings_at
from mismatch.pattern import drawn
from mismatch.race import race
from mismatch.score import Score, start_of
from mismatch.simulation import Simulation

# Parts of the way to where a score says, of which the first that is better than nothing is gone: what is fitted already
# has not moved over, and where it would by much the whole way leads far from any fit.
PARTS = (1.0, 0.25, 0.06, 0.015)


def begun(train: Simulation, before: Fit, chosen: Sequence[Score], prices: Sequence[float]) -> list[Descent]:
    """Fits of forms beside those of a fit, each where some of the frames bring it, if that is better than without it.

    prices: as `race` takes them.
    """
    brought = _brought(train, before, chosen, prices)

    def nearer(i: int) -> Descent:
        if i in brought:
            there = Descent(train, (*before.forms, chosen[i].form), brought[i], before.frame_gain_sigma)
            if there.deviance < before.deviance:
                return there
        return start(train, before, chosen[i])

    return train.each(nearer, range(len(chosen)))


def start(simulation: Simulation, before: Fit, found: Score) -> Descent:
    """The fit of a form beside those of a fit of the same frames, at its start."""
    for part in PARTS:
        x = np.concatenate([before.x, start_of(found.form, part * found.amplitude)])
        there = Descent(simulation, (*before.forms, found.form), x, before.frame_gain_sigma)
        if there.deviance < before.deviance:
            break
    return there


def _brought(train: Simulation, before: Fit, chosen: Sequence[Score], prices: Sequence[float]) -> dict[int, np.ndarray]:
    """Coordinates to which some of the frames bring fits, of those that these tell as well, and at less cost."""
    some = Beside(train, before).some
    if some is None:
        return {}
    ahead = [i for i, found in enumerate(chosen) if _told_by_some(before, found)]
    descents = some.simulation.each(lambda i: start(some.simulation, some.fitted, chosen[i]), ahead)
    race(descents, [prices[i] for i in ahead])
    return {i: descent.x for i, descent in zip(ahead, descents, strict=True)}


def _told_by_some(before: Fit, found: Score) -> bool:
    """Whether some frames tell where a form is: not of what looks at each, mixes them, or has many numbers."""
    forms = (*before.forms, found.form)
    x = np.concatenate([before.x, start_of(found.form, found.amplitude)])
    mixed = any(setting.effect.mixes(setting.values) for setting in settings_at(forms, x))
    return not (mixed or any(form.looks for form in forms) or drawn(forms).size)

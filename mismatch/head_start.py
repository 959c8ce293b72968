"""Where fits of many frames begin: where some of the frames, which cost less, bring them."""

from collections.abc import Sequence

import numpy as np

from mismatch.beside import Beside
from mismatch.descent import Descent
from mismatch.fit import Fit
from mismatch.form import Form, settings_at
from mismatch.pattern import drawn
from mismatch.race import race
from mismatch.score import Score, start_of
from mismatch.simulation import Simulation


def begun(train: Simulation, before: Fit, chosen: Sequence[Score], prices: Sequence[float]) -> list[Descent]:
    """Fits of forms beside those of a fit, each where some of the frames bring it, if that is better than without it.

    prices: as `race` takes them.
    """
    forms = [(*before.forms, found.form) for found in chosen]
    starts = [np.concatenate([before.x, start_of(found.form, found.amplitude)]) for found in chosen]
    brought = _brought(train, before, forms, starts, prices)

    def nearer(i: int) -> Descent:
        if i in brought:
            there = Descent(train, forms[i], brought[i], before.frame_gain_sigma)
            if there.deviance < before.deviance:
                return there
        return Descent(train, forms[i], starts[i], before.frame_gain_sigma)

    return train.each(nearer, range(len(chosen)))


def _brought(
    train: Simulation,
    before: Fit,
    forms: list[tuple[Form, ...]],
    starts: list[np.ndarray],
    prices: Sequence[float],
) -> dict[int, np.ndarray]:
    """Coordinates to which some of the frames bring fits, of those that these tell as well, and at less cost."""
    some = Beside(train, before).some
    if some is None:
        return {}
    part = some.simulation
    ahead = [i for i, x in enumerate(starts) if _told_by_some(forms[i], x)]
    descents = part.each(lambda i: Descent(part, forms[i], starts[i], before.frame_gain_sigma), ahead)
    race(descents, [prices[i] for i in ahead])
    return {i: descent.x for i, descent in zip(ahead, descents, strict=True)}


def _told_by_some(forms: tuple[Form, ...], x: np.ndarray) -> bool:
    """Whether some frames tell where these forms are: not of what looks at each, mixes them, or has many numbers."""
    mixed = any(setting.effect.mixes(setting.values) for setting in settings_at(forms, x))
    return not (mixed or any(form.looks for form in forms) or drawn(forms).size)

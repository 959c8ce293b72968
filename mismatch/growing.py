"""Effects that become more, or less, in the course of the session."""

from dataclasses import replace

import numpy as np

from mismatch.coordinate import to_coordinate
from mismatch.cost import cost
from mismatch.fit import Fit, fit, on_others
from mismatch.form import Form
from mismatch.noise import Nuisances
from mismatch.poisson import LEAST
from mismatch.simulation import Simulation
from physics.setting import GROWS, OF_EVERY, SETTLES, STRONG_AT, warmed
from recordings.refusal import Refusal

# Deviance that growing must promise for a fit to be worth the while.
WORTH = 10.0
# Parts of the session in which it may settle; 0 where it goes on.
SETTLED_IN = (0.0, 1 / 3, 1 / 10)


def grown(train: Simulation, test: Simulation, chosen: Fit) -> Fit:
    """The fit with its last effect growing, or fading, where that is likelier and fits frames held out better."""
    *before, form = chosen.forms
    if not form.effect.grows or {p.name for p in OF_EVERY} & {*form.given, *form.free}:
        return chosen
    promised, how = max(_promises(train, chosen), key=lambda one: one[0])
    if promised < WORTH:
        return chosen
    given = tuple(name for name, value in how.items() if name != GROWS.name and value)
    later = replace(form, free=(*form.free, GROWS.name), start=form.start | how, given=(*form.given, *given))
    x = np.append(chosen.x, to_coordinate(GROWS, how[GROWS.name]))
    try:
        found = fit(train, (*before, later), x, chosen.frame_gain_sigma)
    except Refusal:  # Counts cannot be as they would be where it begins.
        return chosen
    likelier = found.deviance + cost(train, found) < chosen.deviance + cost(train, chosen)
    return found if likelier and on_others(test, found)[1] < on_others(test, chosen)[1] else chosen


def steady(form: Form) -> Form:
    """The form of an effect that grows as it is where it does not."""
    of_it = {GROWS.name, STRONG_AT.name, SETTLES.name}
    free, given = (tuple(name for name in names if name not in of_it) for names in (form.free, form.given))
    start = {name: value for name, value in form.start.items() if name not in of_it}
    return replace(form, free=free, given=given, start=start)


def _promises(train: Simulation, chosen: Fit) -> list[tuple[float, dict[str, float]]]:
    """Deviance that growing promises, and how it grows: as it goes on, or settles sooner or later.

    A line through how much of it each frame asks for, weighted by how well the frame tells.
    """
    nuisances = Nuisances(train, chosen.frame_gain_sigma)
    both = chosen.expected, train.expected(chosen.gain, chosen.settings[:-1])
    there, gone = (nuisances.applied(expected) for expected in both)
    change, least = there - gone, np.maximum(there, LEAST)
    told = (change**2 / least).sum(axis=(1, 2))
    asked = (change * (train.counts - there) / least).sum(axis=(1, 2))
    time_s = np.asarray(train.light.time_s, float)
    return [_line(told, asked, time_s, part * float(time_s.max(initial=0.0))) for part in SETTLED_IN]


def _line(told: np.ndarray, asked: np.ndarray, time_s: np.ndarray, settles_s: float) -> tuple[float, dict[str, float]]:
    """What growing promises that settles so.

    told: (F,) information of frames on how much there is. asked: (F,) their scores.
    """
    far = warmed(time_s, settles_s)
    middle = float(told @ far / max(told.sum(), LEAST))
    spread = float(told @ (far - middle) ** 2)
    slope = float(asked @ (far - middle)) / spread if spread > 0 else 0.0
    at_s = middle if settles_s == 0 else -settles_s * float(np.log1p(-middle / settles_s))
    how = {GROWS.name: float(np.clip(slope, GROWS.low, GROWS.high)), STRONG_AT.name: at_s, SETTLES.name: settles_s}
    return slope**2 * spread, how

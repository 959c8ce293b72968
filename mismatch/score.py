"""Score tests: how much better a cause would fit, to first order, after everything already fitted has moved over."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solve
from scipy.special import chdtrc, gammaln

from mismatch.bounded import bounded_least_squares
from mismatch.columns import OF_ZONES
from mismatch.coordinate import to_coordinate
from mismatch.fit import Fit
from mismatch.form import Form
from mismatch.projection import Projection
from mismatch.simulation import Simulation
from physics.effect import Parameter
from recordings.refusal import Refusal

# A direction of which less than this is left after projection is one of those already fitted.
LEFT = 1e-4
TINY, NOTHING = 1e-12, 1e-10


@dataclass(frozen=True, eq=False)
class Score:
    """What a form promises.

    form: which. amplitude: (M,) best multiples of its start, to first order: of each strength, or of each zone or bin
    that has its own. gain: twice the log-likelihood it promises. dof: how many numbers it takes. log_p: logarithm of
    the chance of such a gain by noise. information: deviance that the form would gain were it there at its start; of
    zones or bins that have their own, the one where it shows most. other: what the form promises where what the data
    gave and no fit varies is otherwise, if that is nearly as much.
    """

    form: Form
    amplitude: np.ndarray
    gain: float
    dof: int
    log_p: float
    information: float
    other: "Score | None" = None

    @property
    def beyond_noise(self) -> float:
        """Gain beyond what noise makes: a number for each of many bins gains one of each where nothing is."""
        return self.gain - self.dof


def change_to(simulation: Simulation, fitted: Fit, form: Form, strengths: tuple[str, ...]) -> np.ndarray:
    """(F, P, T) change of expected counts, beside what is fitted, from nothing to the start of some strengths."""
    gone = {name: form.effect.parameter(name).vanishes_at for name in form.strengths if name not in strengths}
    setting = form.effect.at(**(form.start | gone))
    return simulation.expected(fitted.gain, (*fitted.settings, setting)) - fitted.expected


def change_by_edge(simulation: Simulation, fitted: Fit, form: Form) -> np.ndarray:
    """(2, F, P, T) change with the edge before each bin and with the edge after it: even and odd edges by turns."""
    (name,) = form.own
    gone, start = form.effect.parameter(name).vanishes_at, form.start[name]
    number = np.arange(form.sizes[name])
    odd_ones = number.reshape(-1, form.sizes["bin"]) % 2 == 1

    def turn(i: int) -> np.ndarray:
        moved = replace(form, start=form.start | {name: np.where(number % 2 == i, start, gone)})
        return change_to(simulation, fitted, moved, form.strengths)

    even, odd = turn(0), turn(1)
    return np.stack([np.where(odd_ones, odd, even), np.where(odd_ones, even, odd)])


def changes_of(simulation: Simulation, fitted: Fit, form: Form) -> np.ndarray:
    """(M, F, P, T) changes with each strength of a form, or with all of its zones, bins or edges."""
    if not form.own:
        return np.stack([change_to(simulation, fitted, form, (name,)) for name in form.strengths])
    if _axis(form) in ("edge", "zone edge"):
        return change_by_edge(simulation, fitted, form)
    return change_to(simulation, fitted, form, form.strengths)[None]


def _axis(form: Form) -> str:
    """Of what each has its own value."""
    (axis,) = {form.effect.parameter(name).axis for name in form.own}
    return axis


def score(simulation: Simulation, fitted: Fit, projection: Projection, form: Form) -> Score | None:
    """What a form promises, or None where it can change nothing."""
    try:
        return score_by(projection, form, changes_of(simulation, fitted, form))
    except Refusal:
        return None


def score_by(projection: Projection, form: Form, changes: np.ndarray) -> Score | None:
    """What a form promises that makes these changes (M, F, P, T), as `changes_of` has them."""
    if form.own:
        information, promised, before = projection.divided(changes, _axis(form))
    else:
        each = changes.reshape(len(changes), -1).T
        white = projection.whitened(each)
        information, promised = white.T @ white, white.T @ projection.residual
        before = ((each * projection.root[:, None]) ** 2).sum(axis=0)
    kept = (np.diag(information) > LEFT**2 * before) & (before > TINY)
    if not kept.any():
        return None
    inner = information[np.ix_(kept, kept)]
    low, high = (ends[kept] for ends in amplitude_bounds(form, len(kept)))
    if form.own and _axis(form) in OF_ZONES:
        # Of so many the least that would do, where not all are told apart, takes minutes. What projection left of each
        # is as exact as what it was taken from: so much more makes all of it positive.
        # Cells of a million counts stand beside such of one: in units of what was taken from each they are alike.
        unit = 1 / np.sqrt(before[kept])
        alike = inner * np.outer(unit, unit) + NOTHING * np.eye(len(unit))
        amplitude = unit * solve(alike, unit * promised[kept], assume_a="pos")
    else:
        amplitude = np.linalg.lstsq(inner, promised[kept], rcond=1e-10)[0]
    if ((amplitude < low) | (amplitude > high)).any():
        amplitude = bounded_least_squares(inner, promised[kept], low, high, np.clip(amplitude, low, high))
    gain = float(2 * amplitude @ promised[kept] - amplitude @ inner @ amplitude)
    whole = np.zeros(len(kept))
    whole[kept] = amplitude
    dof = int(kept.sum())
    shown = float(np.diag(information).max() if form.own else kept @ information @ kept)
    return Score(form, whole, gain, dof, log_chance(gain, dof), shown)


def log_chance(gain: float, dof: int) -> float:
    """Logarithm of the chance that noise gains as much, by so many numbers."""
    found = chdtrc(dof, max(gain, 0.0))
    if found > 0:
        return float(np.log(found))
    # Far out the tail is its first term (Abramowitz and Stegun 26.4.12), which no number is too small for.
    return float((dof / 2 - 1) * np.log(gain / 2) - gain / 2 - gammaln(dof / 2))


def amplitude_bounds(form: Form, count: int) -> tuple[np.ndarray, np.ndarray]:
    """(M,) each: how many times its start each amplitude may be."""
    lows, highs = [], []
    for name in form.strengths:
        parameter = form.effect.parameter(name)
        # Where zones begin at different values each has bounds of its own.
        span = np.broadcast_to(np.asarray(form.start[name], float) - parameter.vanishes_at, count if form.own else 1)
        times = np.sort([(end - parameter.vanishes_at) / span for end in (parameter.low, parameter.high)], axis=0)
        times = times if parameter.power == 1 else np.maximum(times, 0.0) ** parameter.power
        lows.append(times[0])
        highs.append(times[1])
    if form.own:
        return np.max(lows, axis=0), np.min(highs, axis=0)
    return np.concatenate(lows), np.concatenate(highs)


def suggests(form: Form, parameter: Parameter) -> bool:
    """Whether the form begins where the data have it begin, not where all recordings do."""
    start = form.start[parameter.name]
    return bool(np.ndim(start)) or start not in (parameter.start, *parameter.tries)


def numbers_given(form: Form) -> list[float]:
    """Numbers that the data gave a form and no fit varies; when something is, and choices zone by zone, are none."""
    names = [n for n in form.given if n not in ("since", "strong_at") and not np.ndim(form.start[n])]
    return [float(form.start[n]) for n in names if suggests(form, form.effect.parameter(n))]


def start_of(form: Form, amplitude: np.ndarray) -> np.ndarray:
    """Coordinates from which to fit a form that promises these amplitudes."""
    x = form.at_start()
    for i, (parameter, place) in enumerate(form.coordinates):
        if parameter.vanishes_at is None or (parameter.placed and suggests(form, parameter)):
            continue
        times = amplitude[(place or 0) if form.own else form.strengths.index(parameter.name)]
        if parameter.power != 1:
            times = max(times, 0.0) ** (1 / parameter.power)
        value = parameter.vanishes_at + times * (form.begins(parameter.name, place) - parameter.vanishes_at)
        x[i] = to_coordinate(parameter, float(np.clip(value, parameter.low, parameter.high)))
    return x

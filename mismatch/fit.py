"""Maximum likelihood of a simulation's gain and effects: Poisson noise, and gain that fluctuates with the frames."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mismatch.errors import covariance
from mismatch.form import Form, bounds, settings_at
from mismatch.looks import deviance_at, equations
from mismatch.noise import FrameGains
from mismatch.simulation import Simulation
from mismatch.steps import bounded_step, limits
from physics.effect import Setting
from recordings.refusal import Refusal

STEP = 1e-3
# Deviance by which a step must still gain; far below what one parameter gains by chance.
SETTLED = 0.05
# Levenberg's damping up to which a step is nearly the whole one.
FREE = 0.1
MOST_STEPS = 25
PROFILE_STEPS = 2
MOST_TRIES = 8


@dataclass(frozen=True, eq=False)
class Fit:
    """A model at its best.

    gain: counts per unit of light. forms: what was fitted beside it. x: (N,) coordinates, log gain first.
    expected: (F, P, T). deviance: with the frames' own gains at their best, and what those cost. frame_gain_sigma:
    relative, of frames' gains. simulation: what was fitted.
    """

    gain: float
    forms: tuple[Form, ...]
    x: np.ndarray
    expected: np.ndarray
    deviance: float
    frame_gain_sigma: float
    simulation: Simulation

    @property
    def settings(self) -> tuple[Setting, ...]:
        """The effects at their best."""
        return settings_at(self.forms, self.x)

    @cached_property
    def columns(self) -> np.ndarray:
        """(F·P·T, N) derivatives of expected counts by x; made when they are asked for, as they take renderings."""
        return derivatives(self.simulation, self.forms, self.x, self.expected)

    @cached_property
    def covariance(self) -> np.ndarray:
        """(N, N) of x; made when it is asked for, as it takes renderings."""

        def rise(x: np.ndarray, held: int | None) -> float:
            if held is None:
                reached = deviance_at(gains, self.forms, x, expected_at(self.simulation, self.forms, x))
            else:
                *_, reached = _best(self.simulation, self.forms, x, self.frame_gain_sigma, PROFILE_STEPS, held)
            return reached - self.deviance

        gains = FrameGains(self.simulation, self.frame_gain_sigma)
        _, information = equations(gains, self.forms, self.x, self.expected, self.columns)
        return covariance(self.forms, self.x, information, rise)


def expected_at(simulation: Simulation, forms: tuple[Form, ...], x: np.ndarray) -> np.ndarray:
    """(F, P, T) expected counts at coordinates."""
    return simulation.expected(float(np.exp(x[0])), settings_at(forms, x))


def derivatives(simulation: Simulation, forms: tuple[Form, ...], x: np.ndarray, here: np.ndarray) -> np.ndarray:
    """(F·P·T, N) change of expected counts `here` with each coordinate.

    Where each zone or bin has its own value, all are moved at once: each moves its own counts only. An edge moves the
    bin before it and the one after: even and odd edges are moved one after the other.
    """
    out = np.zeros((here.size, len(x)))
    moved = x.copy()
    moved[0] += STEP
    out[:, 0] = ((expected_at(simulation, forms, moved) - here) / STEP).ravel()
    at = 1
    for form in forms:
        coordinates = form.coordinates
        start = 0
        while start < len(coordinates):
            parameter, place = coordinates[start]
            count = 1 if place is None else form.sizes[parameter.name]
            _, high = bounds(parameter)
            which = slice(at + start, at + start + count)
            step = np.where(x[which] + 2 * STEP > high, -STEP, STEP)
            own = out.reshape(*here.shape, -1)
            axis = None if place is None else parameter.axis
            turns = 2 if axis == "edge" else 1
            for turn in range(turns):
                moved = x.copy()
                moved[which][turn::turns] += step[turn::turns]
                change = expected_at(simulation, forms, moved) - here
                for i in range(turn, count, turns):
                    cells = _moved_cells(axis, i)
                    own[(*cells, at + start + i)] = change[cells] / step[i]
            start += count
        at += len(coordinates)
    return out


def _moved_cells(axis: str | None, i: int) -> tuple[slice, slice, slice]:
    """Which of (F, P, T) counts move with a parameter, or with that of one zone, bin or edge."""
    every, one = slice(None), slice(i, i + 1)
    if axis == "zone":
        return every, one, every
    if axis == "bin":
        return every, every, one
    return every, every, slice(max(i - 1, 0), i + 1) if axis == "edge" else every


def fit(
    simulation: Simulation, forms: tuple[Form, ...], x: np.ndarray, sigma: float = 0.0, *, most_steps: int = MOST_STEPS
) -> Fit:
    """The best of a model, from x on: Fisher scoring with Levenberg's damping, within bounds."""
    x, here, value = _best(simulation, forms, x, sigma, most_steps)
    return Fit(float(np.exp(x[0])), forms, x, here, value, sigma, simulation)


def _best(
    simulation: Simulation,
    forms: tuple[Form, ...],
    x: np.ndarray,
    sigma: float,
    most_steps: int,
    held: int | None = None,
) -> tuple[np.ndarray, np.ndarray, float]:
    """The best coordinates from x on, expected counts there and their deviance. held: a coordinate that stays."""
    low, high = limits(forms)
    x = np.clip(np.asarray(x, float), low, high)
    if held is not None:
        low[held] = high[held] = x[held]
    here = expected_at(simulation, forms, x)
    gains = FrameGains(simulation, sigma)
    value = deviance_at(gains, forms, x, here)
    damping = 1e-3
    for _ in range(most_steps):
        columns = derivatives(simulation, forms, x, here)
        gradient, curvature = equations(gains, forms, x, here, columns)
        better = False
        for _ in range(MOST_TRIES):
            step = bounded_step(gradient, curvature, damping, x, low, high)
            there = np.clip(x + step, low, high)
            try:
                then = expected_at(simulation, forms, there)
            except Refusal:  # Counts that cannot be are a step too far.
                damping = max(10 * damping, 1e-3)
                continue
            reached = deviance_at(gains, forms, there, then)
            if reached < value:
                better, damped = True, damping
                break
            damping = max(10 * damping, 1e-3)
            if np.abs(step).max() < 1e-7:
                break
        if not better:
            break
        won = value - reached
        x, here, value, damping = there, then, reached, damping / 10
        # A short step gains little wherever it is: only one that was hardly damped says that no more is to be had.
        if won < SETTLED and damped <= FREE:
            break
    return x, here, value


def fit_nominal(simulation: Simulation, sigma: float = 0.0) -> Fit:
    """The model with nothing but its gain fitted."""
    light = simulation.expected(1.0) - simulation.expected(1e-12)
    signal = np.maximum(simulation.counts - simulation.expected(1e-12), 0).sum()
    if not light.sum() > 0:
        raise Refusal("no zone sees any light of the scene inside its window, expected maps and geometry that meet")
    gain = max(float(signal / light.sum()), 1e-12)
    return fit(simulation, (), np.array([np.log(gain)]), sigma)


def on_others(simulation: Simulation, fitted: Fit) -> tuple[np.ndarray, float]:
    """Expected counts of frames that were not fitted, and their deviance with the frames' own gains at their best."""
    expected = expected_at(simulation, fitted.forms, fitted.x)
    return expected, deviance_at(FrameGains(simulation, fitted.frame_gain_sigma), fitted.forms, fitted.x, expected)

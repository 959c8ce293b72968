"""Maximum likelihood of a simulation's gain and effects: Poisson noise, and gain that fluctuates with the frames."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from mismatch.columns import Rows, of_frames
from mismatch.derivatives import derivatives, expected_at
from mismatch.descent import MOST_STEPS, Descent
from mismatch.errors import NEAR, covariance
from mismatch.form import Form, settings_at
from mismatch.looks import deviance_at, equations
from mismatch.noise import Nuisances
from mismatch.pattern import Pattern, drawn, shrunk
from mismatch.remembered import Slopes
from mismatch.simulation import Simulation
from mismatch.steps import bounded_step, limits
from physics.setting import Setting
from recordings.refusal import Refusal

# Steps in which others come to their best beside a coordinate that is held, of either kind.
CHORDS, PROFILE_STEPS = 3, 2
# Steps in which numbers that are drawn come to theirs.
SHRINKING_STEPS = 6


@dataclass(frozen=True, eq=False)
class Fit:
    """A model at its best.

    gain: counts per unit of light. forms: what was fitted beside it. x: (N,) coordinates, log gain first.
    expected: (F, P, T). deviance: with the frames' own gains at their best, and what those cost. frame_gain_sigma:
    relative, of frames' gains. simulation: what was fitted. pattern: of numbers that are drawn, None if there are none.
    """

    gain: float
    forms: tuple[Form, ...]
    x: np.ndarray
    expected: np.ndarray
    deviance: float
    frame_gain_sigma: float
    simulation: Simulation
    pattern: Pattern | None = None

    @property
    def numbers(self) -> int:
        """How many coordinates are fitted each by itself."""
        return len(self.x) - (0 if self.pattern is None else len(self.pattern.which))

    @property
    def settings(self) -> tuple[Setting, ...]:
        """The effects at their best."""
        return settings_at(self.forms, self.x)

    @property
    def columns(self) -> Rows:
        """(F·P·T, N) derivatives of expected counts by x; made when they are asked for, as they take renderings."""
        return self._derivatives[0]

    @property
    def slopes(self) -> Slopes | None:
        """Those by numbers of patches, None where there are none."""
        return self._derivatives[1]

    @cached_property
    def _derivatives(self) -> tuple[Rows, Slopes | None]:
        """See `derivatives`."""
        return derivatives(self.simulation, self.forms, self.x, self.expected)

    def of(self, chosen: np.ndarray) -> "Fit":
        """The same model beside some of its frames (N,), whose derivatives are not made again."""
        part = self.simulation.remembered.part(self.simulation, chosen)
        expected, nuisances = self.expected[chosen], Nuisances(part, self.frame_gain_sigma)
        deviance = deviance_at(nuisances, self.forms, self.x, expected)
        nuisances.remember()
        found = replace(self, simulation=part, expected=expected, deviance=deviance)
        vars(found)["_derivatives"] = of_frames(self.columns.T, len(self.expected), chosen).T, None
        return found

    @cached_property
    def covariance(self) -> np.ndarray:
        """(N, N) of x; made when it is asked for, as it takes renderings."""
        nuisances = Nuisances(self.simulation, self.frame_gain_sigma)
        _, information = equations(nuisances, self.forms, self.x, self.expected, self.columns)
        if self.pattern is not None:
            information = information + self.pattern.prior(len(self.x))

        def rise(x: np.ndarray, held: int | None) -> float:
            found = self._deviance_near(nuisances, information, x, held)
            return found - self.deviance

        return covariance(self.forms, self.x, information, rise)

    def _deviance_near(self, nuisances: Nuisances, information: np.ndarray, x: np.ndarray, held: int | None) -> float:
        """Deviance at x, or with the other coordinates at their best beside one that is held there.

        First with slopes as they are at the best of all, so that a step takes one rendering and not one for each
        coordinate; where that rises by more than a standard error would, with slopes as they are there.
        """
        expected = expected_at(self.simulation, self.forms, x)
        lowest = deviance_at(nuisances, self.forms, x, expected)
        if held is None:
            return lowest
        low, high = limits(self.forms)
        low[held] = high[held] = x[held]
        for _ in range(CHORDS):
            score, _ = equations(nuisances, self.forms, x, expected, self.columns)
            there = np.clip(x + bounded_step(score, information, 0.0, x, low, high), low, high)
            then = expected_at(self.simulation, self.forms, there)
            reached = deviance_at(nuisances, self.forms, there, then)
            if reached >= lowest:
                break
            x, expected, lowest = there, then, reached
        if lowest - self.deviance < 1 + NEAR or self.simulation.work.enough:
            return lowest
        return Descent(self.simulation, self.forms, x, self.frame_gain_sigma, held).run(PROFILE_STEPS).deviance


def fit(
    simulation: Simulation, forms: tuple[Form, ...], x: np.ndarray, sigma: float = 0.0, *, most_steps: int = MOST_STEPS
) -> Fit:
    """The best of a model, from x on: Fisher scoring with Levenberg's damping, within bounds."""
    descent = Descent(simulation, forms, x, sigma).run(most_steps)
    return reached(descent) if most_steps else _there(descent)


def reached(descent: Descent) -> Fit:
    """The fit that a descent has come to; numbers that are drawn are shrunk."""
    found, forms = _there(descent), descent.forms
    if not drawn(forms).size:
        return found
    simulation, nuisances = descent.simulation, descent.nuisances
    _, information = equations(nuisances, forms, found.x, found.expected, found.columns)
    x, pattern = shrunk(forms, found.x, information)
    x = np.clip(x, descent.low, descent.high)
    expected = expected_at(simulation, forms, x)
    deviance = deviance_at(nuisances, forms, x, expected)
    if deviance + pattern.unlikely(x) > found.deviance + pattern.unlikely(found.x):
        # Counts do not go straight that far: of others beside the numbers some may be hardly told. Step by step, then.
        slow = Descent(simulation, forms, found.x, nuisances.sigma, pattern=pattern).run(SHRINKING_STEPS)
        pattern = replace(pattern, cost=pattern.cost + pattern.unlikely(slow.x) - pattern.unlikely(x))
        x, expected, deviance = slow.x, slow.expected, slow.deviance
    return Fit(float(np.exp(x[0])), forms, x, expected, deviance, nuisances.sigma, simulation, pattern)


def _there(descent: Descent) -> Fit:
    """The fit where a descent is."""
    x, sigma = descent.x, descent.nuisances.sigma
    gain = float(np.exp(x[0]))
    return Fit(gain, descent.forms, x, descent.expected, descent.deviance, sigma, descent.simulation)


def begin_beside(simulation: Simulation, fitted: Fit) -> None:
    """Fits of these frames are to begin with an estimated clock as it is beside this one."""
    if simulation.loose is not None:
        nuisances = Nuisances(simulation, fitted.frame_gain_sigma)
        nuisances.settled(expected_at(simulation, fitted.forms, fitted.x))
        nuisances.remember()


def fit_nominal(simulation: Simulation, sigma: float = 0.0) -> Fit:
    """The model with nothing but its gain fitted."""
    light = simulation.expected(1.0) - simulation.expected(1e-12)
    signal = np.maximum(simulation.counts - simulation.expected(1e-12), 0).sum()
    if not light.sum() > 0:
        raise Refusal("no zone sees any light of the scene inside its window, expected maps and geometry that meet")
    gain = max(float(signal / light.sum()), 1e-12)
    found = fit(simulation, (), np.array([np.log(gain)]), sigma)
    if simulation.remembered.clock is None:
        begin_beside(simulation, found)
    return found


def on_others(simulation: Simulation, fitted: Fit) -> tuple[np.ndarray, float]:
    """Expected counts of frames that were not fitted, and their deviance with the frames' own gains at their best."""
    expected = expected_at(simulation, fitted.forms, fitted.x)
    return expected, deviance_at(Nuisances(simulation, fitted.frame_gain_sigma), fitted.forms, fitted.x, expected)

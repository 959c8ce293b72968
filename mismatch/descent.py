"""A fit on its way to the best coordinates: Fisher scoring with Levenberg's damping, one step after another."""

import numpy as np

from mismatch.derivatives import derivatives, expected_at
from mismatch.form import Form
from mismatch.looks import deviance_at, equations
from mismatch.noise import Nuisances
from mismatch.pattern import Pattern, held
from mismatch.secant import Secant
from mismatch.simulation import Simulation
from mismatch.steps import bounded_step, limits
from recordings.refusal import Refusal

# Deviance by which a step must still gain; far below what one parameter gains by chance.
SETTLED = 0.05
# And where much is left beyond noise, this part of it: names are told apart by more.
SETTLED_PART = 1e-5
# Levenberg's damping up to which a step is nearly the whole one.
FREE = 0.1
MOST_STEPS = 25
MOST_TRIES = 8
# A step is followed by others that gain as much at most: so many.
AHEAD = 5.0


class Descent:
    """Where a fit is, and what it may still come to.

    simulation: what is fitted. forms: what beside the gain. x: (N,) coordinates, log gain first. expected: (F, P, T)
    there. deviance: with the frames' own gains at their best, and what those cost. over: whether no more is to be had,
    or `MOST_STEPS` were taken.
    hoped: deviance that it may come to, as its last step was; minus infinity before the first.
    """

    def __init__(
        self,
        simulation: Simulation,
        forms: tuple[Form, ...],
        x: np.ndarray,
        sigma: float,
        stays: int | None = None,
        pattern: Pattern | None = None,
    ) -> None:
        """From coordinates x on. sigma: relative, of frames' gains. stays: a coordinate that does.

        pattern: how numbers are drawn, where that is known.
        """
        self.simulation, self.forms, self.nuisances = simulation, forms, Nuisances(simulation, sigma)
        self.low, self.high = limits(forms)
        self.x = np.clip(np.asarray(x, float), self.low, self.high)
        if stays is not None:
            self.low[stays] = self.high[stays] = self.x[stays]
        self.expected = expected_at(simulation, forms, self.x)
        self.deviance = deviance_at(self.nuisances, forms, self.x, self.expected)
        self._nothing, self._slopes = np.zeros(len(self.x)), simulation.remembered.slopes
        self._precision = np.diag(held(forms)) if pattern is None else pattern.prior(len(self.x))
        if pattern is not None:
            self._nothing[pattern.which] = pattern.nothing
        self.hoped, self.over, self._damping, self._steps, self._secant = -np.inf, False, 1e-3, 0, Secant()

    def run(self, most_steps: int = MOST_STEPS) -> "Descent":
        """So many steps, or until it is over."""
        for _ in range(most_steps):
            if self.over:
                break
            self._step()
        return self

    def _step(self) -> None:
        """One step, with as much damping as it takes to gain."""
        columns, self._slopes = derivatives(self.simulation, self.forms, self.x, self.expected, self._slopes)
        gradient, curvature = equations(self.nuisances, self.forms, self.x, self.expected, columns, nearly=True)
        gradient = gradient - self._precision @ (self.x - self._nothing)
        curvature = self._secant.curvature(gradient, curvature + self._precision)
        whole = bounded_step(gradient, curvature, 0.0, self.x, self.low, self.high)
        promised = float(2 * gradient @ whole - whole @ curvature @ whole)
        for _ in range(MOST_TRIES):
            step = bounded_step(gradient, curvature, self._damping, self.x, self.low, self.high)
            there = np.clip(self.x + step, self.low, self.high)
            try:
                then = expected_at(self.simulation, self.forms, there)
            except Refusal:  # Counts that cannot be are a step too far.
                self._damping = max(10 * self._damping, 1e-3)
                continue
            reached = deviance_at(self.nuisances, self.forms, there, then)
            won = self.deviance - reached + self._unlikely(self.x) - self._unlikely(there)
            if won > 0:
                break
            self._damping = max(10 * self._damping, 1e-3)
            if np.abs(step).max() < 1e-7:
                self.over = True
                return
        else:
            self.over = True
            return
        damped = self._damping
        self._secant.took(there - self.x, won, damped > FREE)
        self.x, self.expected, self.deviance, self._damping = there, then, reached, damped / 10
        self.hoped = reached - AHEAD * max(won, promised - won)
        # A short step gains little wherever it is: only one that was hardly damped says that no more is to be had.
        self._steps += 1
        settled = max(SETTLED, SETTLED_PART * (reached - then.size))
        self.over = (won < settled and damped <= FREE) or self._steps == MOST_STEPS

    def _unlikely(self, x: np.ndarray) -> float:
        """Deviance of numbers that are drawn, or held at nothing."""
        away = x - self._nothing
        return float(away @ self._precision @ away)

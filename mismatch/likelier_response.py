"""An estimated response made likelier under the nominal model, of which it is to be a part."""

from dataclasses import replace

import numpy as np
from scipy.optimize import nnls

from calibrate.impulse.cells import in_steps
from mismatch.blocks import halves
from mismatch.clock_slopes import longer
from mismatch.fit import fit_nominal
from mismatch.poisson import LEAST
from mismatch.simulation import Simulation
from physics.arrivals import Arrivals, arrivals
from physics.clock import NOTHING, Clock
from physics.pulse import ImpulseResponse
from physics.setting import Setting, in_order

# Bins before and after an estimated response in which there may be more of it; turns in which it is told how much, and
# standard deviations from which on it is believed.
BEFORE, AFTER, TURNS, SURE = 12, 64, 3, 2.0
# Deviance per cell beyond which the nominal model is no guide to the response.
FAR = 100.0
# Rounds of so many steps each; after each the zones' delays are told anew, none by more than so many bins.
ROUNDS, STEPS, FARTHEST_BINS = 6, 30, 0.3


def likelier_clock(
    simulation: Simulation, gain: float = 1.0, settings: tuple[Setting, ...] = (), every: bool = False
) -> Clock:
    """The clock of a simulation with the response and delays of zones likeliest of its frames that choose.

    gain, settings: a model of it, beside which they are to be; the nominal one if none is given. every: of all frames,
    once nothing is to be judged any more.

    As they were estimated, gain and lateness of each zone and frame were free, the response was smooth, and ended where
    frames laid over one another did not show it; here all counts share one gain, and what comes earlier and later is
    sought. Then steps of the response are parts of a sum, of which each step of an iteration gives each its part of
    every count (Richardson 1972, J. Opt. Soc. Am. 62, 55; Lucy 1974, Astron. J. 79, 745); what counts do not tell apart
    stays as smooth as it was. Delays have the mean 0: what all share is the response's; where time zeros of zones hold
    they are all 0. Where the nominal model is far
    off, as beside real scenes, it would take up what is amiss, and the clock stays.
    """
    chosen = np.arange(len(simulation.counts)) if every else halves(len(simulation.counts))[0]
    part = simulation.of(chosen)
    if not settings and fit_nominal(part).deviance > FAR * part.counts.size:
        return simulation.clock
    alive = np.flatnonzero(part.counts.any(axis=(0, 2)))
    clock = longer(part.clock, BEFORE, AFTER)
    for turn in range(ROUNDS):
        part = replace(simulation, clock=clock).of(chosen)
        cells = _Cells(part, _light(part, gain, settings), alive, gain, settings)
        response = cells.with_ends() if turn == 0 else cells.response * cells.gain
        for _ in range(STEPS):
            response = cells.stepped(response)
        delay = np.zeros(part.counts.shape[1])
        farthest = FARTHEST_BINS * cells.per_bin
        if not simulation.timed:
            delay[alive] = np.clip([cells.late(i, response) for i in range(len(alive))], -farthest, farthest)
            delay[alive] -= delay[alive].mean()
        held = np.flatnonzero(response > 0)
        there = slice(held[0], held[-1] + 1)
        pulse = ImpulseResponse(cells.time_s[there], response[there] / response.sum())
        clock = replace(clock, pulse=pulse, time_zero_s=clock.time_zero_s + delay * cells.step_s)
    return clock


def _light(part: Simulation, gain: float, settings: tuple[Setting, ...]) -> Arrivals:
    """What arrives at zones by effects that are there in all frames and look at none but their own; by one pulse."""
    now = part.rendering(gain)
    acting = [s for s in in_order(settings) if not s.since_s and not s.grows and not s.effect.mixes(s.values)]
    for noun in ("light", "footprints", "arrivals"):
        if noun == "arrivals":
            now = replace(now, arrivals=arrivals(now.light, now.footprints, now.clock))
        for setting in acting:
            if noun in setting.effect.changes:
                now = replace(now, **{noun: setting.effect.apply(noun, setting.values, now)})
    return replace(now.arrivals, pulses=None)


class _Cells:
    """Counts of zones beside the light that each step of the response would put there, and what else there is.

    That is what no laser sent; and, where there are `settings`, by how much counts differ from that light by those that
    act on something else.
    """

    def __init__(
        self, part: Simulation, light: Arrivals, alive: np.ndarray, gain: float, settings: tuple[Setting, ...]
    ) -> None:
        clock = part.clock
        rest = np.broadcast_to(np.asarray(part.background, float)[:, None], part.counts.shape)
        if settings:
            rest = part.expected(gain, settings) - gain * light.binned()
        self.per_bin, self.step_s = light.lattice.per_bin, light.lattice.step_s
        self.response = np.diff(light.lattice.cumulative)
        # The lattice leaves out what is nothing at the beginning and at the end.
        first = int(np.searchsorted(clock.pulse.edge_cumulative, NOTHING, side="right")) - 1
        self.time_s = clock.pulse.edges[first] + self.step_s * (np.arange(len(self.response)) + 0.5)
        self.zones = []
        for zone in alive:
            design = in_steps(light, zone).reshape(-1, len(self.response))
            reached = design.any(axis=1)
            seen = part.counts[:, zone].ravel()[reached]
            self.zones.append((design[reached].astype(np.float32), seen, rest[:, zone].ravel()[reached]))

    @property
    def gain(self) -> float:
        """Counts beyond the background over light."""
        light = sum(float((design @ self.response).sum()) for design, _, _ in self.zones)
        return max(sum(float((seen - level).sum()) for _, seen, level in self.zones), 1.0) / max(light, LEAST)

    def with_ends(self) -> np.ndarray:
        """(N,) the response with what comes before and after it, even within each bin, where counts are sure of it.

        Least squares with weights of the counts expected, nothing below 0 (Lawson and Hanson 1974).
        """
        first, last = BEFORE * self.per_bin, len(self.response) - AFTER * self.per_bin
        ways = np.zeros((len(self.response), 1 + BEFORE + AFTER))
        ways[first:last, 0] = self.response[first:last]
        for k in range(BEFORE + AFTER):
            start = k * self.per_bin if k < BEFORE else last + (k - BEFORE) * self.per_bin
            ways[start : start + self.per_bin, 1 + k] = 1.0
        columns = [(design @ ways, seen, level) for design, seen, level in self.zones]
        much = np.zeros(ways.shape[1])
        much[0] = self.gain
        for _ in range(TURNS):
            normal, aim = np.zeros((len(much), len(much))), np.zeros(len(much))
            for column, seen, level in columns:
                weight = 1 / np.maximum(column @ much + level, 0.1)
                normal += column.T @ (weight[:, None] * column)
                aim += column.T @ (weight * (seen - level))
            normal += 1e-12 * np.trace(normal) * np.eye(len(much))
            root = np.linalg.cholesky(normal)
            much = nnls(root.T, np.linalg.solve(root, aim))[0]
        sigma = np.sqrt(np.diag(np.linalg.inv(normal)))
        sure = much > SURE * sigma
        sure[0] = True
        return ways @ np.where(sure, much, 0)

    def stepped(self, response: np.ndarray) -> np.ndarray:
        """Each step times the mean ratio, over the counts it is a part of, of recorded to expected."""
        ratio, weight = np.zeros(len(response)), np.zeros(len(response))
        for design, seen, level in self.zones:
            ratio += (seen / np.maximum(design @ response + level, LEAST)) @ design
            weight += design.sum(axis=0)
        return response * np.where(weight > 0, ratio / np.where(weight > 0, weight, 1), 1)

    def late(self, zone: int, response: np.ndarray) -> float:
        """Steps by which a zone is late: a scoring step of its likelihood."""
        design, seen, level = self.zones[zone]
        expected = np.maximum(design @ response + level, LEAST)
        later = design @ np.gradient(-response)
        return float((later * (seen / expected - 1)).sum() / max((later**2 / expected).sum(), LEAST))

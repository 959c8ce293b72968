"""How well a response describes frames that took no part in its estimate."""

from dataclasses import replace

import numpy as np

from calibrate.impulse.estimate import ImpulseEstimate
from calibrate.impulse.problem import Problem
from calibrate.impulse.search import JITTER_BINS, LONGEST, beginning
from calibrate.impulse.sweep import Sweep

STEPS = 30
QUIET = 1e-4
OWN = ("log_gain", "log_pedestal", "late")


def deviance_per_cell(
    sweep: Sweep, estimate: ImpulseEstimate, response: np.ndarray | None = None, zones: list[int] | None = None
) -> np.ndarray:
    """(len(zones),) deviance per cell of frames, of which gains, pedestals and small delays alone are fitted.

    About 1 where counts scatter as photons do; of cells that the pulse can reach. response: (N,) or (P, N) another one
    on the steps of the estimate, which is compared alike; the estimate's own where None. zones: all where None.
    """
    shape, zones = estimate.shape, list(range(sweep.counts.shape[1])) if zones is None else zones
    step = estimate.bin_width_s / shape.per_bin
    stretch = estimate.bin_width_s / sweep.bin_width_s - 1
    response = estimate.probability if response is None else response
    out = []
    for zone in zones:
        delay = np.broadcast_to(estimate.delay_s[zone] / step, (len(sweep.counts), 1))
        curve = response if response.ndim == 1 else response[zone]
        jitter = float(np.broadcast_to(estimate.jitter_s, sweep.counts.shape[1])[zone]) / step
        out.append(_one(sweep, estimate, curve, zone, delay, stretch, jitter))
    return np.array(out)


def _one(
    sweep: Sweep,
    estimate: ImpulseEstimate,
    response: np.ndarray,
    zone: int,
    delay: np.ndarray,
    stretch: float,
    jitter: float,
) -> float:
    """The deviance per cell of one zone, delayed by `delay` (F, 1) steps."""
    shape = estimate.shape
    jitter = max(jitter, JITTER_BINS[0] * shape.per_bin)
    cells = sweep.cells(shape, [zone], delay, stretch)
    start = beginning(sweep, shape, cells, response)
    state = start
    for _ in range(STEPS):
        problem = Problem(cells, shape, start, False, False, state, jitter)
        _, inner, pull, _, _ = problem.own(0, state, response, np.ones(len(cells[0].frame)))
        change = np.clip(np.linalg.solve(inner, pull[..., None]), -LONGEST, LONGEST)
        moved = {name: getattr(state, name) + change[:, i] for i, name in enumerate(OWN)}
        state = replace(state, **moved)
        cells = sweep.cells(shape, [zone], delay + state.late, stretch)
        if np.abs(change).max() < QUIET:
            break
    problem = Problem(cells, shape, start, False, False, state, jitter)
    rate, _, _ = problem.rate(0, state, response)
    tested = cells[0].many == 1
    return float(cells[0].counted.deviance(np.maximum(rate, 1e-300))[tested].mean())

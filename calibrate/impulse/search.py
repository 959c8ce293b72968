"""The search: scoring steps for response, delays, gains and pedestals; evidence for smoothness and model noise."""

from dataclasses import dataclass, replace

import numpy as np

from calibrate.impulse.cells import Cells
from calibrate.impulse.problem import Problem, State, plus
from calibrate.impulse.shape import ORDER, Shape, normalised
from calibrate.impulse.start import reach, stack
from calibrate.impulse.sweep import Sweep
from recordings.refusal import Refusal

MOST_STEPS = 80
# Search ends where a step would gain less than this log likelihood, and smoothness has settled to this share.
GAIN, SETTLED = 1e-2, 0.02
# Steps of logarithms are kept within this, delays within so many bins.
LONGEST, FARTHEST_BINS = 2.0, 0.5
REMAKE_STEPS = 1e-2
# Least and largest standard deviation of a frame's lateness.
JITTER_BINS = 5e-3, 0.5
SMOOTHNESS = 1e-4, 1e8
# Cells with fewer counts than this say nothing about their scatter.
FEWEST = 3.0


@dataclass(frozen=True, eq=False)
class Found:
    """Where the search ended.

    information: (Q, Q) precision of coefficients, delays and bin width. smoothness: of the prior. scatter: variance of
    counts in units of the one expected. noise: relative scatter beyond it. settled: whether the search had ended.
    """

    problem: Problem
    state: State
    information: np.ndarray
    smoothness: float
    scatter: float
    noise: float
    settled: bool


def search(sweep: Sweep, shape: Shape, zones: list[int], clock: bool) -> Found:
    """The response common to `zones`; their delays where they are several, the bin width where `clock` says so."""
    cells = sweep.cells(shape, zones, np.zeros(len(zones)), 0.0)
    start = beginning(sweep, shape, cells)
    problem = Problem(cells, shape, start, len(zones) > 1, clock, start, JITTER_BINS[0] * shape.per_bin)
    state, smoothness, noise, scatter = start, 1.0, 0.0, 1.0
    weights = [np.ones(len(c.frame)) for c in cells]
    settled = False
    for _ in range(MOST_STEPS):
        change, information, spread = problem.step(state, smoothness, weights)
        state, gained = line_search(problem, state, change, smoothness, weights)
        late = state.delay - problem.base.delay + state.late - problem.base.late
        walked = (state.stretch - problem.base.stretch) * max(c.travel_steps.max() for c in problem.cells)
        if max(np.abs(late).max(), abs(walked)) > REMAKE_STEPS:
            made = sweep.cells(shape, zones, state.delay + state.late, state.stretch)
            problem = replace(problem, cells=made, base=state)
        covariance = np.linalg.inv(information)
        scatter, new = model_noise(problem, state, determined(problem, smoothness, covariance))
        noisier = abs(new - noise) > SETTLED * max(new, 1e-4)
        noise = new
        weights = weigh(problem, state, noise)
        smoother = smoothest(shape, state, covariance, smoothness)
        jitter = unsteadiness(problem, state, spread)
        quiet = gained < GAIN and abs(np.log(smoother / smoothness)) < SETTLED and not noisier
        quiet = quiet and abs(jitter - problem.jitter) < SETTLED * problem.jitter
        smoothness, problem = smoother, replace(problem, jitter=jitter)
        if quiet:
            settled = True
            break
    _, information, _ = problem.step(state, smoothness, weights)
    return Found(problem, state, information, smoothness, scatter, noise, settled)


def shape_of(sweep: Sweep, per_bin: int) -> Shape:
    """How long a response the counts show: laid over one another at their nominal arrivals."""
    guess = Shape(per_bin, 0.5, 0.0, 0.5)
    places, values, sigma = stack(sweep.arrivals(guess), sweep.counts, sweep.alive)
    before, peak, after = reach(places, values, sigma, sweep.counts.shape[2])
    return Shape(per_bin, before, peak, after)


def beginning(sweep: Sweep, shape: Shape, cells: list[Cells], response: np.ndarray | None = None) -> State:
    """A response from all frames laid over one another where none is given; gains, pedestals from sums of counts."""
    places, values, sigma = stack(sweep.arrivals(shape), sweep.counts, sweep.alive)
    values = np.maximum(np.interp(shape.offsets / shape.per_bin, places, np.maximum(values, sigma)), 1e-9)
    basis = shape.basis
    ridge = 1e-2 * shape.roughness + 1e-6 * np.eye(basis.shape[1])
    coefficients = np.linalg.solve(basis.T @ basis + ridge, basis.T @ np.log(values / values.max()))
    frames = len(sweep.counts)
    gain, pedestal = np.zeros((frames, len(cells))), np.zeros((frames, len(cells)))
    response = normalised(basis @ coefficients) if response is None else response
    for zone, c in enumerate(cells):
        away = c.many * (c.design.sum(axis=1) == 0)
        level = (c.by_frame(c.counted.counts * (away > 0)) + 0.5) / (c.by_frame(c.counted.alive * (away > 0)) + 1)
        light = c.by_frame(c.design @ response * c.counted.alive)
        if not (light > 0).all():
            f = int(np.argmin(light > 0))
            raise Refusal(f"frame {f}: no light of the scene reaches zone {zone}, expected a surface in its view")
        near = c.many * (away == 0)
        signal = c.by_frame(c.counted.counts * (near > 0)) - level * c.by_frame(c.counted.alive * (near > 0))
        gain[:, zone], pedestal[:, zone] = np.maximum(signal, 1.0) / light, level
    return State(coefficients, np.zeros(len(cells)), 0.0, np.log(gain), np.log(pedestal), np.zeros_like(gain))


def line_search(
    problem: Problem, state: State, change: State, smoothness: float, weights: list[np.ndarray]
) -> tuple[State, float]:
    """As far along the step as the objective grows, and by how much it does."""
    before = problem.objective(state, smoothness, weights)
    own = max(np.abs(change.log_gain).max(), np.abs(change.log_pedestal).max())
    response = normalised(problem.shape.basis @ state.coefficients)
    # A logarithm of next to nothing may move as it likes.
    seen = np.abs(problem.shape.basis @ change.coefficients)[response > 1e-4 * response.max()].max()
    delay = max(np.abs(change.delay).max(), np.abs(change.late).max()) / problem.shape.per_bin
    part = min(1.0, LONGEST / max(own, seen, 1e-12), FARTHEST_BINS / max(delay, 1e-12))
    for _ in range(12):
        ahead = plus(state, change, part)
        with np.errstate(over="ignore", invalid="ignore"):
            after = problem.objective(ahead, smoothness, weights)
        if after >= before:
            return ahead, after - before
        part /= 3
    return state, 0.0


def smoothest(shape: Shape, state: State, covariance: np.ndarray, smoothness: float) -> float:
    """The smoothness of larger evidence (MacKay 1992, Neural Comput. 4, 415; Wood & Fasiolo 2017, Biometrics 73, 1071).

    The prior's degrees of freedom that data leave to it, over the roughness there is.
    """
    k = len(state.coefficients)
    free = k - ORDER - smoothness * float(np.einsum("ij,ji->", shape.roughness, covariance[:k, :k]))
    rough = float(state.coefficients @ shape.roughness @ state.coefficients)
    wanted = max(free, 1e-3) / max(rough, 1e-12)
    return float(np.clip(np.clip(wanted, smoothness / 30, smoothness * 30), *SMOOTHNESS))


def weigh(problem: Problem, state: State, noise: float) -> list[np.ndarray]:
    """(M,) weight of each zone's cells: variance of counting over that and the model's own."""
    if noise == 0:
        return [np.ones(len(c.frame)) for c in problem.cells]
    return [v / (v + (noise * m * (c.many == 1)) ** 2 + 1e-300) for c, m, v in moments(problem, state)]


def unsteadiness(problem: Problem, state: State, spread: np.ndarray) -> float:
    """The standard deviation of lateness, steps, of larger evidence; by the same rule as smoothness."""
    free = float((1 - np.minimum(spread / problem.jitter**2, 1)).sum())
    wanted = np.sqrt(np.square(state.late).sum() / max(free, 1e-3))
    wanted = np.clip(wanted, problem.jitter / 3, problem.jitter * 3)
    return float(np.clip(wanted, *(np.array(JITTER_BINS) * problem.shape.per_bin)))


def determined(problem: Problem, smoothness: float, covariance: np.ndarray) -> float:
    """How many directions of the response the counts determine, rather than the prior."""
    k = problem.shape.basis.shape[1]
    return k - float(np.einsum("ij,ji->", problem.prior(smoothness), covariance[:k, :k]))


def model_noise(problem: Problem, state: State, degrees: float) -> tuple[float, float]:
    """Pearson's χ² over its degrees of freedom; and the relative noise of the model that would bring it to 1."""
    every = moments(problem, state)
    tested = [(c.many == 1) & (m > FEWEST) for c, m, v in every]
    mean, variance = (np.concatenate([e[i][t] for e, t in zip(every, tested, strict=True)]) for i in (1, 2))
    square = np.concatenate([(c.counted.counts[t] - m[t]) ** 2 for (c, m, _), t in zip(every, tested, strict=True)])
    # Pedestals are told by bins beside the pulse.
    free = len(square) - state.log_gain.size - degrees
    if free <= 0:
        return 1.0, 0.0
    scatter = float((square / variance).sum()) / free
    if scatter < 1 + 3 * np.sqrt(2 / free):
        return scatter, 0.0
    low, high = np.log(1e-6), np.log(10.0)
    for _ in range(40):
        middle = (low + high) / 2
        more = (square / (variance + (np.exp(middle) * mean) ** 2)).sum() > free
        low, high = (middle, high) if more else (low, middle)
    return scatter, float(np.exp((low + high) / 2))


def moments(problem: Problem, state: State) -> list[tuple[Cells, np.ndarray, np.ndarray]]:
    """Each zone's cells with mean and variance of their counts."""
    response = normalised(problem.shape.basis @ state.coefficients)
    out = []
    for zone, cells in enumerate(problem.cells):
        rate, _, _ = problem.rate(zone, state, response)
        out.append((cells, *cells.counted.moments(rate)))
    return out

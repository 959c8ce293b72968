"""A correction that knows no physics: smooth in zone, time in the pulse, signal and range, learnt from residuals."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline

from mismatch.blocks import halves
from mismatch.covariates import covariates
from mismatch.poisson import LEAST, deviance
from mismatch.simulation import Simulation

# Bins before and after the mean arrival that are told apart; what is beyond is taken like the outermost.
BEFORE, AFTER = 5.0, 13.0
# Change of the logarithm of counts from bin to bin: beyond, flanks are alike.
STEEPEST = 2.0
# How many splines there are over time in the pulse, signal, range, counts expected in a cell, and how steep they are.
PULSE, SIGNAL, RANGE, CELL, SLOPE = 20, 6, 6, 8, 8
SMOOTHNESS = (1e-1, 1e0, 1e1, 1e2, 1e3)
# Of the penalty on curvature, that on size: what no data tell is no correction.
RIDGE = 1e-2
MOST_STEPS = 15
SETTLED = 0.05
LARGEST = 5.0  # of the logarithm of a correction


@dataclass(frozen=True, eq=False)
class BlackBox:
    """log(recorded / simulated) as a sum of splines. ends: (3, 2) of log signal, log arrival and log expected counts
    that were seen: beyond, the correction stays what it is at the end. smoothness: of SMOOTHNESS. weights: (K,).
    """

    ends: np.ndarray
    smoothness: float
    weights: np.ndarray

    def expected(self, simulation: Simulation, nominal: np.ndarray) -> np.ndarray:
        """(F, P, T) corrected counts of any frames. nominal: (F, P, T), what the simulation without it expects."""
        change = _design(simulation, nominal, self.ends) @ self.weights
        return nominal * np.exp(np.clip(change, -LARGEST, LARGEST)).reshape(nominal.shape)


def fit_black_box(simulation: Simulation, nominal: np.ndarray) -> BlackBox:
    """The best correction of a simulation's frames; how smooth it is they decide themselves, half on the other half."""
    ends = _ends(simulation, nominal)
    design, counts, mean = _design(simulation, nominal, ends), simulation.counts.ravel(), nominal.ravel()
    penalty = _penalty(simulation.counts.shape[1])
    frame = np.repeat(np.arange(len(nominal)), nominal[0].size)
    parts = [np.isin(frame, half) for half in halves(len(nominal))]

    def lost(smoothness: float) -> float:
        total = 0.0
        for own, other in (parts, parts[::-1]):
            weights = _fitted(design[own], counts[own], mean[own], smoothness * penalty)
            there = mean[other] * np.exp(np.clip(design[other] @ weights, -LARGEST, LARGEST))
            total += float(deviance(counts[other], there).sum())
        return total

    best = min(SMOOTHNESS, key=lost)
    return BlackBox(ends, best, _fitted(design, counts, mean, best * penalty))


def _fitted(design: np.ndarray, counts: np.ndarray, mean: np.ndarray, penalty: np.ndarray) -> np.ndarray:
    """(K,) weights of a penalised Poisson regression with logarithmic link (Eilers and Marx 1996): Newton's method."""
    weights = np.zeros(design.shape[1])
    mean = np.maximum(mean, LEAST)

    def loss(weights: np.ndarray) -> tuple[float, np.ndarray]:
        there = mean * np.exp(np.clip(design @ weights, -LARGEST, LARGEST))
        return float(deviance(counts, there).sum() + weights @ penalty @ weights), there

    value, there = loss(weights)
    for _ in range(MOST_STEPS):
        gradient = design.T @ (counts - there) - penalty @ weights
        step = np.linalg.solve((design * there[:, None]).T @ design + penalty, gradient)
        for _ in range(6):
            reached, then = loss(weights + step)
            if reached < value:
                break
            step /= 4
        else:
            break
        won, weights, value, there = value - reached, weights + step, reached, then
        if won < SETTLED:
            break
    return weights


def _places(simulation: Simulation, nominal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(F, P, T) bins after the mean arrival; (3, F, P, T) log signal, log arrival after time zero, log expected."""
    found = covariates(simulation, nominal)
    bins = np.arange(nominal.shape[2]) + 0.5
    zero = np.broadcast_to(simulation.clock.time_zero_s, found.arrival_bins.shape) / simulation.clock.bin_width_s
    of_zone = np.stack([np.log(np.maximum(found.signal, 1)), np.log(np.maximum(found.arrival_bins - zero, 0.1))])
    spread = np.broadcast_to(of_zone[..., None], (2, *nominal.shape))
    return bins - found.arrival_bins[..., None], np.concatenate([spread, np.log(np.maximum(nominal, LEAST))[None]])


def _ends(simulation: Simulation, nominal: np.ndarray) -> np.ndarray:
    """(3, 2) least and most of what a correction goes by."""
    _, places = _places(simulation, nominal)
    low, high = places.min(axis=(1, 2, 3)), places.max(axis=(1, 2, 3))
    return np.stack([low, np.maximum(high, low + 1e-3)], axis=1)


def _design(simulation: Simulation, nominal: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """(F·P·T, K) splines: time in the pulse by zone, by signal and by range, flanks by signal, counts in the cell."""
    after, (signal, arrival, cell) = _places(simulation, nominal)
    pulse = _splines(after, (-BEFORE, AFTER), PULSE)
    zones = np.broadcast_to(np.arange(nominal.shape[1])[:, None], nominal.shape).ravel()
    by_zone = _product(np.eye(nominal.shape[1])[zones], pulse)
    by_signal = _product(_splines(signal, ends[0], SIGNAL), pulse)
    by_range = _product(_splines(arrival, ends[1], RANGE), pulse)
    flank = _splines(np.gradient(cell, axis=2), (-STEEPEST, STEEPEST), SLOPE)
    by_flank = _product(_splines(signal, ends[0], SIGNAL), flank)
    return np.hstack([by_zone, by_signal, by_range, by_flank, _splines(cell, ends[2], CELL)])


def _splines(values: np.ndarray, ends: tuple[float, float] | np.ndarray, count: int) -> np.ndarray:
    """(N, count) cubic B-splines between two ends; beyond, as at the end."""
    low, high = ends
    knots = low + (high - low) * np.arange(-3, count + 1) / (count - 3)
    # The last knot inside belongs to no interval.
    inside = np.clip(values.ravel(), low, high - 1e-9 * (high - low))
    return BSpline.design_matrix(inside, knots, 3).toarray()


def _product(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """(N, A·B) products of the rows of (N, A) and (N, B)."""
    return (one[:, :, None] * other[:, None, :]).reshape(len(one), -1)


def _penalty(zones: int) -> np.ndarray:
    """(K, K) squared second differences along each axis, zones among themselves excepted, and a little of each size."""
    pulse, signal, range_, cell, flank = (_rough(n) for n in (PULSE, SIGNAL, RANGE, CELL, SLOPE))
    products = [(signal, pulse), (range_, pulse), (signal, flank)]
    blocks = [
        np.kron(np.eye(zones), pulse),
        *(np.kron(one, np.eye(len(other))) + np.kron(np.eye(len(one)), other) for one, other in products),
        cell,
    ]
    size = sum(len(block) for block in blocks)
    out, at = RIDGE * np.eye(size), 0
    for block in blocks:
        out[at : at + len(block), at : at + len(block)] += block
        at += len(block)
    return out


def _rough(count: int) -> np.ndarray:
    """(count, count) sum of squared second differences."""
    second = np.diff(np.eye(count), 2, axis=0)
    return second.T @ second

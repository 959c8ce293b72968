"""Goodness of fit: residuals summed over many divisions of the cells, so that no misfit of any shape stays hidden."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.stats import gamma, poisson

from mismatch.covariates import covariates
from mismatch.directions import Directions
from mismatch.fit import Fit
from mismatch.noise import Nuisances
from mismatch.poisson import LEAST
from mismatch.projection import Projection
from mismatch.simulation import Simulation

# Groups in which fewer counts are expected are left out: their noise is not normal.
ENOUGH = 8.0
QUANTILES = 8
# Bins before and after the mean arrival that are told apart one by one; those beyond are one group each.
BEFORE, AFTER = 6, 14
# Relative change of the signal from bin to bin by which flanks are told apart.
FLANKS = (-0.5, -0.2, -0.05, 0.05, 0.2, 0.5)
TINY = 1e-9
COVARIATES = ("signal", "arrival_bins", "phase", "incidence", "reflectance", "neighbours")
LOOKED = (
    ("bin",),
    ("aligned",),
    ("flank",),
    ("zone",),
    ("frame",),
    ("zone", "bin"),
    ("zone", "aligned"),
    ("zone", "flank"),
    ("frame", "zone"),
    ("frame", "bins"),
    ("frame", "part"),
    ("frame", "flank"),
    ("frame", "zone", "part"),
    ("time", "bins"),
    ("time", "aligned"),
    ("time", "zone", "bins"),
    ("time", "zone", "aligned"),
    *((name, kind) for name in COVARIATES for kind in ("aligned", "part", "flank")),
)


@dataclass(frozen=True, eq=False)
class Division:
    """One way to divide the cells. axes: what they are divided by. group: (F, P, T) number of each cell's group."""

    axes: tuple[str, ...]
    group: np.ndarray


@dataclass(frozen=True, eq=False)
class Table:
    """Residuals summed by group. excess: (G,) counts; noise: (G,) standard deviation; chi2, its mean and p-value."""

    division: Division
    excess: np.ndarray
    noise: np.ndarray
    chi2: float
    expected: float
    p_value: float


def divisions(simulation: Simulation, expected: np.ndarray) -> list[Division]:
    """All divisions that are looked through."""
    found, shape = covariates(simulation, expected), simulation.counts.shape
    frames = shape[0]
    frame, zone, bin_ = np.indices(shape, sparse=True)
    aligned = np.clip(bin_ - np.floor(found.arrival_bins)[..., None].astype(int), -BEFORE, AFTER) + BEFORE
    part = np.digitize(aligned - BEFORE, [-BEFORE + 1, -1, 1, 4, AFTER])
    # Which flank of which pulse a cell lies on, by how fast its signal rises: for scenes of several surfaces.
    signal = np.maximum(expected - simulation.dark, 0)
    rise = np.gradient(signal, axis=2) / np.maximum(signal, TINY)
    flank = np.where(signal > 0.1 * expected, np.digitize(rise, FLANKS) + 1, 0)
    coarse_time = frame * min(QUANTILES, frames) // frames
    names = {
        "frame": frame,
        "zone": zone,
        "bin": bin_,
        "aligned": aligned,
        "part": part,
        "flank": flank,
        "time": coarse_time,
        "bins": bin_ // 4,
    }
    for name in COVARIATES:
        values = getattr(found, name)
        edges = np.quantile(values, np.arange(1, QUANTILES) / QUANTILES)
        names[name] = np.digitize(values, edges)[..., None]
    out = []
    for axes in LOOKED:
        group = np.zeros(shape, np.int64)
        for name in axes:
            group = group * (int(names[name].max()) + 1) + names[name]
        out.append(Division(axes, group))
    return out


def tables(simulation: Simulation, fitted: Fit) -> list[Table]:
    """Every division's residuals beside a fit of the same frames."""
    projection = Projection(simulation, fitted)
    mean = np.maximum(Nuisances(simulation, fitted.frame_gain_sigma).applied(fitted.expected), LEAST)
    residual = projection.left / projection.root
    every = divisions(simulation, fitted.expected)
    return [table(division, residual, mean.ravel(), projection.own, projection.root) for division in every]


def table(division: Division, residual: np.ndarray, mean: np.ndarray, own: Directions, root: np.ndarray) -> Table:
    """One division's; residual, mean: (F·P·T,) counts. own: what a fit can make of them, whitened by `root`.

    What is fitted takes off of the sums' chi-square only what it can make of them: the sums' covariance is 1 - A·Aᵀ
    with A (G, K) what it makes of them, whitened.
    """
    group = division.group.ravel()
    excess, variance = np.bincount(group, residual), np.bincount(group, mean)
    enough = variance >= ENOUGH
    each = excess[enough] ** 2 / variance[enough]
    sums = csr_array((1 / root, (group, np.arange(group.size))))[np.flatnonzero(enough)]
    taken = own.products(sums) / np.sqrt(variance[enough])[:, None]
    square = taken.T @ taken
    chi2, degrees = float(each.sum()), max(float(enough.sum() - np.trace(square)), 1.0)
    spread = 2 * max(enough.sum() - 2 * np.trace(square) + (square**2).sum(), 1.0) + (1 / variance[enough]).sum()
    # A gamma distribution of the same mean and variance: chi-square where many counts are expected.
    if not enough.any():
        return Table(division, excess, np.sqrt(variance), 0.0, 1.0, 1.0)
    widespread = float(gamma.sf(chi2, degrees**2 / spread, scale=spread / degrees))
    p = min(1.0, 2 * min(widespread, _worst(excess[enough], variance[enough])))
    return Table(division, excess, np.sqrt(variance), chi2, degrees, p)


def _worst(excess: np.ndarray, mean: np.ndarray) -> float:
    """Chance that the worst of the groups is as bad, were their sums Poisson counts: misfit in few groups."""
    # Projection takes off a little of what was counted: no counts may come out as a little less than none.
    found = np.maximum(mean + excess, 0)
    tail = np.minimum(poisson.sf(np.ceil(found - 1e-9) - 1, mean), poisson.cdf(np.floor(found + 1e-9), mean))
    return float(min(1.0, 2 * len(mean) * tail.min()))

"""An estimated clock at its best beside a model: begun where it was beside another, from nothing, and by scipy."""

import time
from dataclasses import replace

import numpy as np
from scipy.optimize import minimize

from mismatch.clock_slopes import clock_slopes
from mismatch.fit import fit_nominal
from mismatch.noise import Nuisances
from mismatch.poisson import deviance

from .bench_explain import recording


def by_scipy(simulation, expected):
    """L-BFGS (Liu and Nocedal 1989) on all numbers of the clock, with their slopes."""
    rows = simulation.loose_rows.astype(float)
    counts, mean = simulation.counts.ravel(), expected.ravel()

    def loss(b):
        there = np.maximum(mean + b @ rows, 1e-3)
        return deviance(counts, there).sum() + b @ b, 2 * (rows @ (1 - counts / there) + b)

    return minimize(loss, np.zeros(len(rows)), jac=True, method="L-BFGS-B").fun


def test_deviance_beside_an_estimated_clock():
    """96 frames of 9 zones and 128 bins, a model 1 % fainter than the last."""
    known = recording(96, None)
    gain = fit_nominal(known).gain
    simulation = replace(known, loose=clock_slopes(known, gain))
    expected, taken, found = simulation.expected(gain), {}, {}
    last = Nuisances(simulation, 0.0)
    last.deviance(1.01 * expected)
    last.remember()
    begun = simulation.remembered.clock

    def ours(clock):
        simulation.remembered.clock = clock
        return Nuisances(simulation, 0.0).deviance(expected)

    ways = {
        "begun": lambda: ours(begun),
        "from nothing": lambda: ours(None),
        "scipy": lambda: by_scipy(simulation, expected),
    }
    for _ in range(5):
        for name, way in ways.items():
            begin = time.perf_counter()
            found[name] = way()
            taken.setdefault(name, []).append(time.perf_counter() - begin)
    median = {name: 1e3 * np.median(times) for name, times in taken.items()}
    print(f"\n{len(simulation.loose)} numbers: " + ", ".join(f"{name} {ms:.0f} ms" for name, ms in median.items()))
    assert max(found.values()) - min(found.values()) < 0.5
    assert median["begun"] < median["from nothing"] < median["scipy"]

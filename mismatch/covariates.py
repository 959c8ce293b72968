"""What a misfit may go with: range, signal, phase in the bin, incidence and so on, of each zone in each frame."""

from dataclasses import dataclass

import numpy as np

from mismatch.simulation import Simulation

TINY = 1e-12


@dataclass(frozen=True, eq=False)
class Covariates:
    """Of every zone p in frame f, (F, P) each.

    signal: counts expected without background. arrival_bins: mean arrival of that signal, bins. phase: its place in its
    bin, 0 to 1. incidence: mean cosine of the surfaces the zone sees, by how much light they return. reflectance:
    their mean reflectance. neighbours: signal of the other zones, relative to the zone's own.
    """

    signal: np.ndarray
    arrival_bins: np.ndarray
    phase: np.ndarray
    incidence: np.ndarray
    reflectance: np.ndarray
    neighbours: np.ndarray


def covariates(simulation: Simulation, expected: np.ndarray) -> Covariates:
    """Of the frames of a simulation whose expected counts are `expected`."""
    signal = np.maximum(expected - simulation.dark, 0)
    total = signal.sum(axis=2)
    bins = np.arange(signal.shape[2]) + 0.5
    arrival = (signal @ bins) / np.maximum(total, TINY)
    incidence, reflectance = _seen(simulation)
    others = total.sum(axis=1, keepdims=True) - total
    return Covariates(total, arrival, arrival % 1, incidence, reflectance, others / np.maximum(total, TINY))


def _seen(simulation: Simulation) -> tuple[np.ndarray, np.ndarray]:
    """(F, P) mean cosine and reflectance of what zones see, by the light it returns."""
    light, seen = simulation.light, simulation.footprints.seen
    frames = light.frames
    strength = light.returns[0].strength.reshape(frames, -1)
    means = []
    for values in (light.cosine, light.reflectance):
        values = np.nan_to_num(values).reshape(frames, -1)
        out = []
        for i in range(frames):
            pixels, weights = seen[i % len(seen)]
            light_there = strength[i, pixels]
            out.append((light_there * values[i, pixels]) @ weights / np.maximum(light_there @ weights, TINY))
        means.append(np.array(out))
    return means[0], means[1]

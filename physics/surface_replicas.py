"""Which surface alone seems to come once more, and how much later."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.constants import speed_of_light

from physics.arrivals import arrivals
from physics.rendering import Rendering
from physics.replicas import DARK, correlation, peaks
from physics.told_apart import numbers, surfaces_alone

# So many of the largest surfaces are looked at; their pixels may move through many frames.
LARGEST = 8
# Counts of a surface over all frames from which on its replica could show.
BRIGHT = 100.0


@dataclass(frozen=True)
class SurfaceReplica:
    """A second pulse of one surface. surface: values that choose it. spacing_m: behind it, negative before it.

    evidence: square of how many standard deviations there are more counts there than expected.
    """

    surface: dict[str, float]
    spacing_m: float
    evidence: float


def surface_replicas(
    excess: np.ndarray, expected: np.ndarray, rendering: Rendering, most: int = 2
) -> list[SurfaceReplica]:
    """The surfaces and spacings at which a replica of one surface would explain most of an excess, best first.

    excess: (F, P, T) recorded less expected counts. Matched filters for white noise (Turin 1960, IRE Trans. Inf. Theory
    6, 311) at all spacings at once, as correlations; no nearer than the pulse is long, where a gain would do as well.
    """
    clock, light, bins = rendering.clock, rendering.light, expected.shape[-1]
    direct, noise = light.returns[0], 1 / np.maximum(expected, DARK)
    mean_s = float((clock.pulse.time_s * clock.pulse.probability).sum())
    long_s = np.sqrt(float(((clock.pulse.time_s - mean_s) ** 2 * clock.pulse.probability).sum()))
    shifts = np.arange(1 - bins, bins)
    apart = np.abs(shifts) * clock.bin_width_s > max(long_s, clock.bin_width_s)
    found = []
    for which in surfaces_alone(light, LARGEST):
        there = numbers(which, light) == which["surface"]
        only = replace(direct, strength=np.where(there, direct.strength, 0))
        seen = arrivals(replace(light, returns=(only,)), rendering.footprints, clock).binned() * rendering.gain
        if seen.sum() < BRIGHT:
            continue
        promised = correlation(seen, excess * noise).sum(axis=(0, 1))
        information = correlation(seen**2, noise).sum(axis=(0, 1))
        shown = apart & (information > 1)
        evidence = np.where(shown, np.maximum(promised, 0) ** 2 / np.where(shown, information, 1), 0)
        for at, much in peaks(evidence)[:1]:
            metres = (at - (bins - 1)) * clock.bin_width_s * speed_of_light / 2
            found.append(SurfaceReplica(which, float(metres), much))
    return sorted(found, key=lambda one: -one.evidence)[:most]

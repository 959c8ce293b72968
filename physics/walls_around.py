"""Light that reaches surfaces by way of walls on all sides of the sensor, and how far off these seem to be."""

import numpy as np
from scipy.constants import speed_of_light

from physics.light import Return
from physics.rendering import Rendering

# Distances that are tried, metres.
TRIED = np.geomspace(0.05, 5.0, 40)
NEAREST_M = 0.05


def by_walls_around(direct: Return, distance_m: float) -> Return:
    """What comes back by way of walls at this distance from the sensor's axis, perfect ones.

    The mean of planes on all sides: a source that lies twice as far aside lights a target at r from √(r² + 4d²).
    """
    by_wall = np.hypot(direct.range_m, 2 * distance_m)
    dimmer = (direct.range_m / np.maximum(by_wall, NEAREST_M)) ** 2
    return Return((direct.range_m + by_wall) / 2, (direct.strength * dimmer).astype(np.float32))


def likely_distances(excess: np.ndarray, expected: np.ndarray, rendering: Rendering, most: int = 2) -> list[float]:
    """Distances of walls around by way of which light is as late as what is in excess, the likeliest first.

    excess, expected: (F, P, T) counts. Matched filters, with the mean range of what each zone sees in each frame.
    """
    clock, bins = rendering.clock, expected.shape[-1]
    metres = clock.bin_width_s * speed_of_light / 2
    light = np.maximum(expected - rendering.background, 0)
    noise = 1 / np.maximum(expected, 1)
    late_s = float(clock.pulse.time_s @ clock.pulse.probability)
    zero_bins = (np.atleast_2d(clock.time_zero_s) + late_s) / clock.bin_width_s
    mean_bins = light @ (np.arange(bins) + 0.5) / np.maximum(light.sum(axis=-1), 1e-12)
    ranges = np.maximum((mean_bins - zero_bins) * metres, NEAREST_M)
    evidence = np.empty(len(TRIED))
    for i, distance in enumerate(TRIED):
        by_wall = np.hypot(ranges, 2 * distance)
        lag = np.rint((by_wall - ranges) / 2 / metres).astype(int)
        source = np.arange(bins) - lag[..., None]
        later = np.take_along_axis(light, np.clip(source, 0, bins - 1), -1) * (source >= 0)
        later *= ((ranges / by_wall) ** 2)[..., None]
        promised = max(float((excess * noise * later).sum()), 0.0)
        evidence[i] = promised**2 / max(float((later**2 * noise).sum()), 1e-12)
    padded = np.concatenate([[0], evidence, [0]])
    tops = np.flatnonzero((evidence > padded[:-2]) & (evidence >= padded[2:]))
    return [float(TRIED[i]) for i in tops[np.argsort(-evidence[tops])][:most]]

"""A pane set in a surface, a window in a wall: where it is in space, as an excess of counts tells."""

from collections.abc import Sequence

import numpy as np
from numba import njit
from scipy.constants import speed_of_light

from physics.marks import balls, looked_at, received
from physics.rendering import Rendering
from physics.replicas import DARK

# A sheet in front is no nearer to the sensor than this, metres.
NEAREST_M = 0.05


def likely_pane(
    excess: np.ndarray, expected: np.ndarray, rendering: Rendering, spacings_m: Sequence[float]
) -> tuple[float, dict[str, float]] | None:
    """The ball in space whose light, once more from farther away, explains most of an excess; None where none would.

    excess, expected: (F, P, T) counts. spacings_m: by how much farther it may be. The best of these, and values that
    place a ball named "pane". Matched filters for white noise (Turin 1960, IRE Trans. Inf. Theory 6, 311): of a pulse
    that is lost at each pixel and one that is found behind it, by the inverse square; beside a gain of the whole.
    """
    clock, some = rendering.clock, looked_at(rendering.light)
    signal, noise = np.maximum(expected - rendering.background, 0), 1 / np.maximum(expected, DARK)
    excess = excess - signal * (signal * excess * noise).sum() / max(float((signal**2 * noise).sum()), 1e-300)
    pulses = clock.pulse.in_bins((np.arange(clock.bins) + 0.5) * clock.bin_width_s, clock.bins, clock.bin_width_s)
    amiss, told = (excess * noise) @ pulses.T, noise @ (pulses**2).T
    ranges = np.nan_to_num(rendering.light.range_m[some]).astype(float)
    sent = rendering.gain * np.nan_to_num(rendering.light.returns[0].strength[some]).astype(float)
    weights = rendering.footprints.weights[some]
    zero = np.ascontiguousarray(np.broadcast_to(np.asarray(clock.time_zero_s, float), amiss.shape[:2]))
    per_metre, zero = 2 / speed_of_light / clock.bin_width_s, zero / clock.bin_width_s
    flat = ranges.reshape(len(ranges), -1)
    promised = []
    for far in spacings_m:
        by_zone = _twice(amiss, zero, flat, far, per_metre, 1).reshape(*zero.shape, *ranges.shape[1:])
        promised.append(sent * (weights * by_zone).sum(axis=-3))
    best, found = 0.0, None
    for place, inside in balls(rendering.light):
        there = sent * inside
        mean = (there * ranges).sum(axis=(1, 2)) / np.maximum(there.sum(axis=(1, 2)), 1e-300)
        light = received(there, weights) ** 2
        for far, at in zip(spacings_m, promised, strict=True):
            noisy = _twice(told, zero, mean[:, None], far, per_metre, 2)[..., 0]
            evidence = max(float(at[inside].sum()), 0.0) ** 2 / max(float((light * noisy).sum()), 1e-300)
            if evidence > best:
                best, found = evidence, (far, {f"pane_{name}": value for name, value in place.items()})
    return found


@njit(nogil=True, cache=True)
def _twice(by_arrival, zero, ranges, far, per_metre, power):
    """(F, P, N) what (F, P, T) by bin of arrival is for a second pulse, so much dimmer to a power; plus the first's.

    Less the first's where the power is 1, as that is lost. zero: (F, P) bins. ranges: (F, N) metres of the first, far:
    how much farther the second is. Outside the window is nothing.
    """
    frames, zones, bins = by_arrival.shape
    out = np.zeros((frames, zones, ranges.shape[1]))
    for f in range(frames):
        for i in range(ranges.shape[1]):
            behind = max(ranges[f, i] + far, NEAREST_M)
            dimmer = (ranges[f, i] / behind) ** (2 * power)
            for p in range(zones):
                first, second = zero[f, p] + ranges[f, i] * per_metre, zero[f, p] + behind * per_metre
                if 0 <= second < bins:
                    out[f, p, i] += dimmer * by_arrival[f, p, int(second)]
                if 0 <= first < bins:
                    out[f, p, i] += (-1.0) ** power * by_arrival[f, p, int(first)]
    return out

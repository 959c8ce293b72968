"""A pane set in a surface, a window in a wall: where it is in space, as an excess of counts tells."""

from collections.abc import Sequence

import numpy as np
from scipy.constants import speed_of_light

from physics.clock import Clock
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
    by_zone = [weights[..., p, :, :] for p in range(expected.shape[1])]
    promised = [
        sent * sum(w * _twice(amiss, p, ranges, far, clock, 1) for p, w in enumerate(by_zone)) for far in spacings_m
    ]
    best, found = 0.0, None
    for place, inside in balls(rendering.light):
        there = sent * inside
        mean = (there * ranges).sum(axis=(1, 2)) / np.maximum(there.sum(axis=(1, 2)), 1e-300)
        light = received(there, weights) ** 2
        for far, at in zip(spacings_m, promised, strict=True):
            noisy = np.stack([_twice(told, p, mean, far, clock, 2) for p in range(len(by_zone))], axis=1)
            evidence = max(float(at[inside].sum()), 0.0) ** 2 / max(float((light * noisy).sum()), 1e-300)
            if evidence > best:
                best, found = evidence, (far, {f"pane_{name}": value for name, value in place.items()})
    return found


def _twice(by_arrival: np.ndarray, zone: int, range_m: np.ndarray, far: float, clock: Clock, power: int) -> np.ndarray:
    """(F, ...) what (F, P, T) by bin of arrival is for a second pulse, so much dimmer to a power; plus the first's.

    Less the first's where the power is 1, as that is lost.
    """
    behind = np.maximum(range_m + far, NEAREST_M)
    second = (range_m / behind) ** (2 * power) * _arriving(by_arrival, zone, behind, clock)
    return second + (-1) ** power * _arriving(by_arrival, zone, range_m, clock)


def _arriving(by_arrival: np.ndarray, zone: int, range_m: np.ndarray, clock: Clock) -> np.ndarray:
    """(F, ...) the same for light of a zone that returns from ranges (F, ...); 0 outside the window."""
    zero = np.broadcast_to(np.asarray(clock.time_zero_s, float), by_arrival.shape[:2])[:, zone]
    zero = zero.reshape(-1, *(1,) * (range_m.ndim - 1))
    arrival = (zero + 2 * range_m / speed_of_light) / clock.bin_width_s
    seen = (arrival >= 0) & (arrival < clock.bins)
    frame = np.arange(len(range_m)).reshape(zero.shape)
    return np.where(seen, by_arrival[frame, zone, np.where(seen, arrival, 0).astype(int)], 0)

"""Surfaces farther than the laser's period allows, in view or where depth is unknown: light one period early."""

from dataclasses import replace

import numpy as np
from scipy.constants import speed_of_light
from scipy.fft import irfft, next_fast_len, rfft

from physics.arrivals import arrivals
from physics.light import Light, Return
from physics.pulse import longer
from physics.rendering import Rendering
from physics.replicas import DARK, correlation

# No farther surface is looked for, metres: it sends back next to nothing.
FARTHEST_M = 40.0
# Periods that are told apart differ by this many bins.
APART_BINS = 3
# A wall that is tilted away further than this is seen edge on.
LEAST_FACING = 0.05
# Of the most that a wall could show, what is too little to tell where it is; and what no division may meet.
TOLD, LEAST = 1e-3, 1e-12


def seen_beyond(light: Light, period_s: float) -> list[Return]:
    """What surfaces in view beyond the period, seconds, send back; none where there are none."""
    far = light.range_m > speed_of_light / 2 * period_s
    if not far.any():
        return []
    return [replace(way, strength=np.where(far, way.strength, 0)) for way in light.returns]


def seen_through(
    light: Light, depth_m: np.ndarray, tilt: tuple[float, float] = (0.0, 0.0), at: tuple[float, float] = (0.0, 0.0)
) -> list[Return]:
    """What a white wall across the view, (F,) metres ahead, sends back where depth is unknown; none where it is known.

    at: tangents x/z and y/z where it is so far ahead. tilt: by what part of its depth it is nearer for each unit of
    them. Strength cosθ/r² as in the nominal model.
    """
    unknown = ~(light.range_m > 0)
    if not unknown.any():
        return []
    normal = np.array([*tilt, 1 - np.dot(tilt, at)])
    length, facing = np.linalg.norm(light.rays, axis=-1), np.maximum(light.rays @ normal, LEAST_FACING)
    ranges = np.where(unknown, length * depth_m[:, None, None] / facing, 0).astype(np.float32)
    cosine = facing / length / np.linalg.norm(normal)
    strength = np.where(unknown & (ranges > 0), cosine / np.where(unknown, ranges, 1) ** 2, 0)
    return [Return(ranges, strength.astype(np.float32))]


def where_unknown(light: Light) -> tuple[float, float]:
    """Mean tangents x/z and y/z of pixels whose depth is unknown; (0, 0) where there are none."""
    unknown = ~(light.range_m > 0)
    if not unknown.any():
        return 0.0, 0.0
    x, y = (unknown * light.rays[..., :2].transpose(2, 0, 1)[:, None]).sum(axis=(1, 2, 3)) / unknown.sum()
    return float(x), float(y)


def one_period_early(rendering: Rendering, returns: list[Return], period_s: float, smear_s: float) -> np.ndarray | None:
    """(F, P, T) counts of light that is registered one period, seconds, early; None where there is none.

    smear_s: standard deviation of the period, by which pulses are longer.
    """
    if not returns:
        return None
    clock, period_m = rendering.clock, np.float32(speed_of_light / 2 * period_s)
    ways = tuple(replace(way, range_m=np.maximum(way.range_m - period_m, 0)) for way in returns)
    smeared = replace(clock, pulse=longer(clock.pulse, smear_s))
    return rendering.gain * arrivals(replace(rendering.light, returns=ways), rendering.footprints, smeared).binned()


def periods(excess: np.ndarray, expected: np.ndarray, rendering: Rendering, most: int = 2) -> list[float]:
    """Periods, seconds, at which light of far surfaces would explain most of an excess (F, P, T), best first.

    Not shorter than the window, into which it would come twice. Matched filters for white noise (Turin 1960, IRE Trans.
    Inf. Theory 6, 311) at all whole bins at once, as correlations.
    """
    light, clock = rendering.light, rendering.clock
    farthest = min(float(np.max(light.range_m, where=np.isfinite(light.range_m), initial=0)), FARTHEST_M)
    last = int(np.ceil((np.max(clock.time_zero_s) + 2 * farthest / speed_of_light) / clock.bin_width_s))
    if last <= clock.bins:
        return []
    signal = arrivals(light, rendering.footprints, replace(clock, bins=last)).binned() * rendering.gain
    noise = 1 / np.maximum(expected, DARK)
    promised, information = _correlation(excess * noise, signal), _correlation(noise, signal**2)
    evidence = np.maximum(promised, 0) ** 2 / np.maximum(information, 1)
    found: list[int] = []
    for at in np.argsort(-evidence[clock.bins :]) + clock.bins:
        if len(found) == most or not evidence[at] > 0:
            break
        if all(abs(at - other) > APART_BINS for other in found):
            found.append(int(at))
    return [at * clock.bin_width_s for at in found]


def walls(
    excess: np.ndarray, expected: np.ndarray, rendering: Rendering, way_m: np.ndarray, period_s: float, smear_s: float
) -> tuple[float, float] | None:
    """How far ahead at the start, metres, a wall seen where depth is unknown explains most of an excess (F, P, T).

    And its evidence, the square of how many standard deviations more counts there are than expected; None where there
    is none. way_m: (F,) by how much it is farther than at the start. Matched filters as in `periods`: a wall so much
    farther is the same light so much later.
    """
    clock = rendering.clock
    metres = clock.bin_width_s * speed_of_light / 2
    middle_s = clock.bins * clock.bin_width_s / 2 - float(np.mean(clock.time_zero_s))
    depth_m = speed_of_light / 2 * (period_s + middle_s)
    seen = one_period_early(rendering, seen_through(rendering.light, depth_m + way_m), period_s, smear_s)
    if seen is None:
        return None
    noise = 1 / np.maximum(expected, DARK)
    promised = correlation(seen, excess * noise).sum(axis=(0, 1))
    information = correlation(seen**2, noise).sum(axis=(0, 1))
    evidence = np.maximum(promised, 0) ** 2 / np.maximum(information, TOLD * information.max(initial=0) + LEAST)
    best = int(np.argmax(evidence))
    return (depth_m + (best - (clock.bins - 1)) * metres, float(evidence[best])) if evidence[best] > 0 else None


def _correlation(first: np.ndarray, later: np.ndarray) -> np.ndarray:
    """(T',) sums over frames, zones and bins of first[..., t]·later[..., t + k], for k from 0 on to the last bin."""
    size = next_fast_len(first.shape[-1] + later.shape[-1], real=True)
    product = (np.conj(rfft(first, size)) * rfft(later, size)).sum(axis=(0, 1))
    return irfft(product, size)[: later.shape[-1]]

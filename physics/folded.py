"""Surfaces in view that are farther than the laser's period allows: their light, counted one period early."""

from dataclasses import replace

import numpy as np
from scipy.constants import speed_of_light
from scipy.fft import irfft, next_fast_len, rfft

from physics.arrivals import arrivals
from physics.light import Return
from physics.pulse import longer
from physics.rendering import Rendering

# No farther surface is looked for, metres: it sends back next to nothing.
FARTHEST_M = 40.0
# Counts that a cell is taken to expect at least: far surfaces show in the dark.
DARK = 0.01
# Periods that are told apart differ by this many bins.
APART_BINS = 3


def folded(rendering: Rendering, period_s: float, smear_s: float) -> np.ndarray | None:
    """(F, P, T) counts of surfaces beyond the period, seconds, one period early; None where there are none.

    smear_s: standard deviation of the period, by which their pulses are longer.
    """
    light, clock = rendering.light, rendering.clock
    period_m = np.float32(speed_of_light / 2 * period_s)
    far = light.range_m > period_m
    if not far.any():
        return None
    ways = tuple(
        Return(np.where(far, way.range_m - period_m, 0), np.where(far, way.strength, 0)) for way in light.returns
    )
    smeared = replace(clock, pulse=longer(clock.pulse, smear_s))
    return rendering.gain * arrivals(replace(light, returns=ways), rendering.footprints, smeared).binned()


def periods(excess: np.ndarray, expected: np.ndarray, rendering: Rendering, most: int = 2) -> list[float]:
    """Periods, seconds, at which light of far surfaces would explain most of an excess (F, P, T), best first.

    Not shorter than the window, into which it would come twice. Matched filters for white noise (Turin 1960, IRE Trans.
    Inf. Theory 6, 311) at all whole bins at once, as correlations.
    """
    light, clock = rendering.light, rendering.clock
    farthest = min(float(np.max(light.range_m, where=np.isfinite(light.range_m), initial=0)), FARTHEST_M)
    last = int(np.ceil((np.max(clock.time_zero_s) + 2 * farthest / speed_of_light) / clock.bin_width_s))
    shortest = clock.bins - int(np.min(clock.time_zero_s) / clock.bin_width_s)
    if last <= shortest:
        return []
    signal = arrivals(light, rendering.footprints, replace(clock, bins=last)).binned() * rendering.gain
    noise = 1 / np.maximum(expected, DARK)
    promised, information = _correlation(excess * noise, signal), _correlation(noise, signal**2)
    # What comes a period early begins at time zero.
    evidence = np.maximum(promised, 0) ** 2 / np.maximum(information, 1)
    found: list[int] = []
    for at in np.argsort(-evidence[shortest:]) + shortest:
        if len(found) == most or not evidence[at] > 0:
            break
        if all(abs(at - other) > APART_BINS for other in found):
            found.append(int(at))
    return [at * clock.bin_width_s for at in found]


def _correlation(first: np.ndarray, later: np.ndarray) -> np.ndarray:
    """(T',) sums over frames, zones and bins of first[..., t]·later[..., t + k], for k from 0 on to the last bin."""
    size = next_fast_len(first.shape[-1] + later.shape[-1], real=True)
    product = (np.conj(rfft(first, size)) * rfft(later, size)).sum(axis=(0, 1))
    return irfft(product, size)[: later.shape[-1]]

"""Surfaces farther than the laser's period allows: light one period early."""

from dataclasses import replace

import numpy as np
from scipy.constants import speed_of_light
from scipy.fft import irfft, next_fast_len, rfft

from physics.arrivals import arrivals
from physics.clock import EARLY_BINS, Clock
from physics.light import Light, Return
from physics.pulse import longer
from physics.rendering import Rendering
from physics.replicas import DARK

# No farther surface is looked for, metres: it sends back next to nothing.
FARTHEST_M = 40.0
# Periods that are told apart differ by this many bins.
APART_BINS = 3


def seen_beyond(light: Light, clock: Clock, period_s: float) -> list[Return]:
    """What surfaces in view send back that is registered a period, seconds, or more after its shot; none where none is.

    The laser fires again a period after it did, and what comes then is counted from the start of bin 0 anew, be it
    before time zero.
    """
    first_s = period_s - float(np.max(clock.time_zero_s)) - EARLY_BINS * clock.bin_width_s
    far = light.range_m > speed_of_light / 2 * first_s
    if not far.any():
        return []
    return [replace(way, strength=np.where(far, way.strength, 0)) for way in light.returns]


def one_period_early(rendering: Rendering, returns: list[Return], period_s: float, smear_s: float) -> np.ndarray | None:
    """(F, P, T) counts of light that is registered one period, seconds, early; None where there is none.

    smear_s: standard deviation of the period, by which pulses are longer.
    """
    if not returns:
        return None
    clock, period_m = rendering.clock, np.float32(speed_of_light / 2 * period_s)
    ways = tuple(replace(way, range_m=way.range_m - period_m) for way in returns)
    smeared = replace(clock, pulse=longer(clock.pulse, smear_s))
    return rendering.gain * arrivals(replace(rendering.light, returns=ways), rendering.footprints, smeared).binned()


def two_periods(light: Light, period_s: float, stagger_s: float, turns: float) -> list[tuple[float, np.ndarray]]:
    """Periods, seconds, and (F,) the part of shots that come after each.

    Half of the shots come after one period, half after one that is longer by `stagger_s`; or frames take turns (`turns`
    1). A laser that does so tells a target beyond the period by its two ranges.
    """
    if not stagger_s:
        return [(period_s, np.ones(light.frames))]
    frames = np.arange(light.frames) if light.part_of is None else light.part_of[1]
    part = (1 - turns) / 2 + turns * (frames % 2)
    return [(period_s, 1 - part), (period_s + stagger_s, part)]


def folds(excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
    """Where fits of light that comes a period early may begin; `_periods` each.

    Of two periods: half of the shots after either, and frames in turn with either first.
    """
    found = []
    for one, *more in _periods(excess, expected, rendering):
        found += [] if more else [{"folded": 1.0, "period": one}]
        for other in more:
            ways = (one, other, 0.0), (one, other, 1.0), (other, one, 1.0)
            found += [{"folded": 1.0, "period": a, "stagger": b - a, "in_turn": turns} for a, b, turns in ways]
    return found


def _periods(excess: np.ndarray, expected: np.ndarray, rendering: Rendering, most: int = 2) -> list[list[float]]:
    """Periods, seconds, at which light of far surfaces would explain most of an excess (F, P, T), best first.

    Each alone, and at last the best together with the one that explains most beside it; none where there is nothing.
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
    if not found:
        return []
    # Of what comes at another period, what comes at the best does not explain already.
    best = found[0]
    early = np.zeros(expected.shape)
    there = signal[..., best : best + clock.bins]
    early[..., : there.shape[-1]] = there
    alike = _correlation(early * noise, signal)
    beside = promised - alike * promised[best] / max(information[best], 1)
    left = np.maximum(information - alike**2 / max(information[best], 1), 1)
    other = clock.bins + int(np.argmax((np.maximum(beside, 0) ** 2 / left)[clock.bins :]))
    alone = [[at * clock.bin_width_s] for at in found]
    return alone if abs(other - best) <= 1 else [*alone, [best * clock.bin_width_s, other * clock.bin_width_s]]


def _correlation(first: np.ndarray, later: np.ndarray) -> np.ndarray:
    """(T',) sums over frames, zones and bins of first[..., t]·later[..., t + k], for k from 0 on to the last bin."""
    size = next_fast_len(first.shape[-1] + later.shape[-1], real=True)
    product = (np.conj(rfft(first, size)) * rfft(later, size)).sum(axis=(0, 1))
    return irfft(product, size)[: later.shape[-1]]

"""Replicas: where in an excess of counts all of what surfaces send back seems to come once more, so much later."""

from dataclasses import dataclass

import numpy as np
from scipy.constants import speed_of_light
from scipy.fft import irfft, next_fast_len, rfft

from physics.intervals import best_interval
from physics.rendering import Rendering

# Of light before the pulse is over nothing can be told by its range: it counts as this far, metres.
NEAREST_M = 0.1
# Counts that a cell is taken to expect at least: an echo in the dark is told by few.
DARK = 0.01
# What is told apart from a gain by less than this part is not told; a replica of all light must gain so much deviance;
# and a spacing with less than this part of the most evidence is none.
TOLD, SHOWN, PROMISING = 1e-3, 10.0, 0.2
# A third pulse is looked for so many bins behind the second; it must tell for this part of what that does.
BEHIND, ALSO = 2, 0.02


@dataclass(frozen=True)
class Replica:
    """A second pulse at a fixed distance. spacing_m: behind the first, negative before it.
    evidence: sum of squares of how many standard deviations there are more counts there than expected.
    nearest_m, farthest_m: ranges between which surfaces seem to have one. evidence_there: of these surfaces alone.
    third: how far behind the second pulse another is, and how much of its light that has; None where none is.
    """

    spacing_m: float
    evidence: float
    nearest_m: float
    farthest_m: float
    evidence_there: float
    third: tuple[float, float] | None = None


class _Matched:
    """Matched filters for all of a zone's light once more, at all spacings, beside a gain of the whole.

    light, noise: (F, P, T) counts, and one over their variance. dimmer: (F, P, 2T - 1) by spacing in bins.
    whole: what tells of the gain. told: (2T - 1,) where a replica can be told from that; free: how well; information:
    (P, 2T - 1) of each zone.
    """

    def __init__(self, light: np.ndarray, noise: np.ndarray, dimmer: np.ndarray, whole: float) -> None:
        self._light, self._noise, self._dimmer = light, noise, dimmer
        self.information = (dimmer**2 * correlation(light**2, noise)).sum(axis=0)
        by_gain = (dimmer * correlation(light, light * noise)).sum(axis=(0, 1))
        total = self.information.sum(axis=0)
        self.free = total - by_gain**2 / max(whole, 1e-12)
        # Where the gain can make nearly all of it, or all of the light once more would not show, there is none.
        self.told = (self.free > TOLD * total) & (total > SHOWN)

    def promised(self, excess: np.ndarray) -> np.ndarray:
        """(P, 2T - 1) how an excess goes with the replica."""
        return (self._dimmer * correlation(self._light, excess * self._noise)).sum(axis=0)

    def third(
        self, excess: np.ndarray, promised: np.ndarray, spacing: float, evidence: float
    ) -> tuple[float, float] | None:
        """Bins behind a second pulse at which another is, of how much of its light; None where nothing tells of one.

        promised: (P, 2T - 1) of the excess. spacing: bins from the first pulse to the second. evidence: for that.
        """
        bins, free = self._light.shape[-1], np.where(self.told, self.free, 1)
        at = spacing + bins - 1
        part = max(float(promised[:, round(at)].sum()), 0.0) / free[round(at)]
        left = excess - part * (self._dimmer[..., round(at), None] * _later(self._light, spacing))
        again = np.maximum(self.promised(left).sum(axis=0), 0) / free
        there = peaks(np.where(self.told & (np.arange(2 * bins - 1) >= at + BEHIND), again**2 * free, 0))
        if part <= 0 or not there or there[0][1] < max(SHOWN, ALSO * evidence):
            return None
        return there[0][0] - at, float(again[round(there[0][0])] / part)


def replicas(
    excess: np.ndarray, expected: np.ndarray, rendering: Rendering, falloff: float, most: int = 2
) -> list[Replica]:
    """Spacings at which a replica of the light in `expected` would explain most of an excess, best first.

    excess: (F, P, T) recorded less expected counts. falloff: power of the ratio of ranges by which it is dimmer. Its
    part of the light is the same in all zones, or each zone's own: the `most` best of either. Matched filters for white
    noise (Turin 1960, IRE Trans. Inf. Theory 6, 311) at all spacings at once, as correlations, beside a free gain.
    """
    clock, bins = rendering.clock, expected.shape[-1]
    metres = clock.bin_width_s * speed_of_light / 2
    light = np.maximum(expected - rendering.background, 0)
    noise = 1 / np.maximum(expected, DARK)
    whole = float((light**2 * noise).sum())
    excess = excess - light * (light * excess * noise).sum() / max(whole, 1e-12)
    ranges = _ranges(rendering, bins)
    shifts = np.arange(1 - bins, bins)
    # By the mean range of what each zone sees: within a pulse the bins do not tell ranges.
    mean = ((light * ranges).sum(axis=-1) / np.maximum(light.sum(axis=-1), 1e-12))[..., None]
    mean = np.maximum(mean, NEAREST_M)
    dimmer = (mean / np.maximum(mean + shifts * metres, NEAREST_M)) ** falloff
    matched = _Matched(light, noise, dimmer, whole)
    promised, told, free = matched.promised(excess), matched.told, matched.free
    alike = np.where(told, np.maximum(promised.sum(axis=0), 0) ** 2 / np.where(told, free, 1), 0)
    each = (np.maximum(promised, 0) ** 2 / np.maximum(matched.information, 1e-12)).sum(axis=0)
    each = np.where(told, each, 0)
    tops = [one for evidence in (alike, each) for one in peaks(evidence)[:most]]
    best: dict[int, tuple[float, float]] = {}
    for at, evidence in sorted(tops, key=lambda one: -one[1]):
        if evidence > PROMISING * max(one[1] for one in tops):
            best.setdefault(round(at), (at, evidence))
    middle = ranges.reshape(-1, bins).mean(axis=0)
    found = []
    for at, evidence in best.values():
        k = shifts[round(at)]
        late, early = slice(max(k, 0), bins + min(k, 0)), slice(max(-k, 0), bins - max(k, 0))
        second = light[..., early] * dimmer[..., round(at), None]
        seen = (excess * noise)[..., late], second * noise[..., late], (light * noise)[..., late]
        first, last, of_these = best_interval(*((second * one).sum(axis=(0, 1)) for one in seen), whole)
        ends = middle[early][[first, max(last - 1, first)]] + np.array([-0.5, 0.5]) * metres
        spacing = float((at - (bins - 1)) * metres)
        behind = k > 0 and not found
        third = matched.third(excess, promised, at - (bins - 1), evidence) if behind else None
        third = None if third is None else (third[0] * metres, third[1])
        found.append(Replica(spacing, evidence, float(ends[0]), float(ends[1]), of_these, third))
    return found


def _later(light: np.ndarray, shift: float) -> np.ndarray:
    """(F, P, T) light so many bins later, between whole ones by parts of both; 0 or more."""
    whole, part = int(shift), shift - int(shift)
    padded = np.concatenate([np.zeros_like(light[..., : whole + 1]), light], axis=-1)
    bins = light.shape[-1]
    return (1 - part) * padded[..., 1 : bins + 1] + part * padded[..., :bins]


def _ranges(rendering: Rendering, bins: int) -> np.ndarray:
    """(1 or F, P, T) range of what arrives in each bin, by the pulse's mean delay; no nearer than can be told."""
    clock, pulse = rendering.clock, rendering.clock.pulse
    late_s = float((pulse.time_s * pulse.probability).sum() / pulse.probability.sum())
    zero = np.atleast_2d(np.asarray(clock.time_zero_s, float))[..., None] + late_s
    ranges = speed_of_light / 2 * ((np.arange(bins) + 0.5) * clock.bin_width_s - zero)
    return np.maximum(ranges, NEAREST_M)


def correlation(first: np.ndarray, later: np.ndarray) -> np.ndarray:
    """(F, P, 2T - 1) sums over bins of first[t]·later[t + k], for k from 1 - T to T - 1."""
    bins = first.shape[-1]
    size = next_fast_len(2 * bins, real=True)
    product = np.conj(rfft(first, size)) * rfft(later, size)
    return np.roll(irfft(product, size), bins - 1, axis=-1)[..., : 2 * bins - 1]


def peaks(evidence: np.ndarray) -> list[tuple[float, float]]:
    """Where it is higher than on either side, between entries as a parabola has it, and how high; the highest first."""
    padded = np.concatenate([[0], evidence, [0]])
    before, after = padded[:-2], padded[2:]
    top = np.flatnonzero((evidence > before) & (evidence >= after))
    bend = 2 * evidence[top] - before[top] - after[top]
    places = top + (after[top] - before[top]) / (2 * bend)
    order = np.argsort(-evidence[top])
    return [(float(places[i]), float(evidence[top[i]])) for i in order]

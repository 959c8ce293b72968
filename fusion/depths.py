"""Depths from histograms: which light comes from which range, as surfaces, by maximum likelihood."""

import numpy as np
from scipy.special import expit, logsumexp

from fusion.climb import climb
from fusion.range_response import RangeResponse
from fusion.surfaces import surfaces
from fusion.zone_view import DEAD, GOOD, SATURATED, ZoneDepths
from physics.workers import in_parallel
from recordings.refusal import Refusal

STEPS = 60
# Where brightness changes the response: so many times what was lost is made good, with so many steps each time.
ROUNDS, STEPS_A_ROUND = 4, 30
MOST_SURFACES = 4
# Light that is nearer than so many widths of the pulse is not told apart with certainty.
NEAR = 3.0
# A counter that is full shows the same number in neighbouring bins; photons do that by chance while there are few.
FULL_BINS, FULL_COUNTS = 3, 64
MOST_MADE_GOOD = 50.0
# Counts per bin: a level of 0 could never rise.
LEAST_LEVEL = 0.02


def zone_depths(
    counts: np.ndarray, response: RangeResponse, background: np.ndarray | None = None, *, steps: int = STEPS
) -> ZoneDepths:
    """Surfaces of every zone from its histogram.

    counts: (P, T) of one frame or (F, P, T) photon counts. background: (P,) counts per bin that no laser sent, held;
    where None they are fitted, which the bins before time zero make certain. Counts are Poisson. Where the sensor loses
    counts to brightness they are multiplied by what its model expects without loss over with, and light that strays
    between zones is added to the model, both at the present estimate, in turn with the fit. Raises `Refusal` where
    shapes do not fit.
    """
    found = np.asarray(counts)
    zones, many, bins = response.counts.shape
    if found.ndim not in (2, 3) or found.shape[-2:] != (zones, bins):
        raise Refusal(f"counts have shape {found.shape}, expected ({zones}, {bins}) or (F, {zones}, {bins})")
    raw = np.ascontiguousarray(found.reshape(-1, zones, bins), float)
    if not (np.isfinite(raw).all() and (raw >= 0).all()):
        raise Refusal("counts hold NaN, infinity or values below 0, expected photon counts")
    state = _states(raw, response)
    held = background is not None
    level = np.array(np.broadcast_to(background, raw.shape[:2]), float) if held else _before(raw, response)
    structure = np.broadcast_to(response.pedestal - response.flat[:, None], raw.shape)
    above = np.maximum(raw - structure - level[..., None], 0).sum(axis=2)
    light = np.repeat(np.maximum(above, 1.0)[..., None] / many, many, axis=2)
    seen, besides = raw, structure
    if response.lossy:
        for _ in range(ROUNDS):
            _fit(response, seen, besides, held, STEPS_A_ROUND, light, level)
            lossless, full = response.linear(light, level), response.expected(light, level)
            # What is more than the sum is there beside it; what is less was lost.
            besides = structure + np.maximum(full - lossless, 0)
            seen = raw * np.clip(lossless / np.maximum(full, 1e-9), 1, MOST_MADE_GOOD)
    _fit(response, seen, besides, held, steps, light, level)
    light[state != GOOD] = 0
    return _described(found.shape[:-2], response, seen, besides, light, level, held, state)


def _fit(
    response: RangeResponse,
    counts: np.ndarray,
    structure: np.ndarray,
    held: bool,
    steps: int,
    light: np.ndarray,
    level: np.ndarray,
) -> None:
    """Improve light (F, P, B) and level (F, P) in place, frames side by side."""
    whose = np.arange(counts.shape[1])

    def one(i: int) -> None:
        climb(counts[i], whose, response.counts, response.bands, structure[i], held, steps, light[i], level[i])

    in_parallel(one, range(len(counts)))


def _before(counts: np.ndarray, response: RangeResponse) -> np.ndarray:
    """(F, P) mean counts of bins that no light from any range reaches; of the darkest quarter where there is none."""
    level = np.empty(counts.shape[:2])
    structure = response.pedestal - response.flat[:, None]
    for p, (reached, crosstalk) in enumerate(zip(response.counts.any(axis=1), structure > 0.1, strict=True)):
        dark = ~reached & ~crosstalk
        rest = counts[:, p] - structure[p]
        few = np.sort(rest, axis=1)[:, : max(rest.shape[1] // 4, 1)]
        level[:, p] = (rest[:, dark] if dark.any() else few).mean(axis=1)
    return np.maximum(level, LEAST_LEVEL)


def _states(counts: np.ndarray, response: RangeResponse) -> np.ndarray:
    """(F, P) which zones cannot be used: no count at all, or a counter that was full and is not modelled."""
    state = np.where(counts.any(axis=2), GOOD, DEAD).astype(np.uint8)
    if any(setting.effect.id == "counter_saturation" for setting in response.sensor.effects):
        return state
    highest = counts.max(axis=2, keepdims=True)
    full = counts == highest
    run = full[:, :, : 1 - FULL_BINS or None].copy()
    for i in range(1, FULL_BINS):
        run &= full[:, :, i : full.shape[2] - FULL_BINS + 1 + i]
    state[run.any(axis=2) & (highest[..., 0] >= FULL_COUNTS)] = SATURATED
    return state


def _described(
    lead: tuple[int, ...],
    response: RangeResponse,
    counts: np.ndarray,
    structure: np.ndarray,
    light: np.ndarray,
    level: np.ndarray,
    held: bool,
    state: np.ndarray,
) -> ZoneDepths:
    """Surfaces of every histogram, and the probability that there is none."""
    table = np.full((4, *level.shape, MOST_SURFACES), np.nan)
    for i, p in np.argwhere(state == GOOD):
        rows, level[i, p] = surfaces(
            light[i, p],
            response.range_m,
            response.counts[p],
            response.bands[p],
            response.fine_m,
            response.fine_counts[p],
            structure[i, p],
            level[i, p],
            counts[i, p],
            held,
            NEAR * response.width_m,
            MOST_SURFACES,
        )
        table[:, i, p, : len(rows)] = rows[:, [2, 0, 3, 4]].T
    nothing = np.where(state == GOOD, _nothing(response, counts, structure, level, held), np.nan)
    shaped = [a.reshape(*lead, *a.shape[1:]) for a in (light, level, *table, nothing, state)]
    return ZoneDepths(response.range_m, *shaped)


def _nothing(
    response: RangeResponse, counts: np.ndarray, structure: np.ndarray, level: np.ndarray, held: bool
) -> np.ndarray:
    """(F, P) probability of no surface against one at any range, at even odds.

    Its likelihood ratio at a range is that of a score test, exp(s²/2I); ranges are equally likely beforehand, and for
    brightness Schwarz's criterion charges half the logarithm of the number of bins.
    """
    # Without any surface, all counts are the level's.
    level = level if held else (counts - structure).mean(axis=2)
    dark = structure + np.maximum(level, LEAST_LEVEL)[..., None]
    score = np.einsum("fpt,pbt->fpb", counts / dark - 1, response.counts, optimize=True)
    information = np.einsum("fpt,pbt->fpb", 1 / dark, response.counts**2, optimize=True)
    gain = np.maximum(score, 0) ** 2 / np.maximum(2 * information, 1e-12)
    ratio = logsumexp(gain, axis=2) - np.log(gain.shape[2]) - np.log(counts.shape[2]) / 2
    return expit(-ratio)

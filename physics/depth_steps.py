"""Depth that comes in steps, as of a camera that counts whole disparities, and surfaces between its steps."""

from dataclasses import replace

import numpy as np
from numba import njit

from physics.geometry import incidence_cosine, incidence_cosine_across_edges
from physics.kept import kept_of_session
from physics.light import Light, Return
from physics.workers import in_parallel

# Numbers that differ by less than this part are one, rounded.
ROUNDED = 2e-6
# Steps there must be, and pixels to each, to be sure that they are.
FEWEST, PIXELS = 8, 20
# So many frames, evenly taken, tell whether there are any.
ASKED = 32
# Part of a step by which gaps may miss whole numbers of them; and of the gaps that must not.
OFF, MOST = 0.1, 0.99
# Cosines that differ by less were told alike.
ALIKE = 1e-3
# Neighbours are of one surface where they are so many steps apart at most; what is between is drawn so often.
APART, TURNS = 2, 40


def between_steps(light: Light) -> tuple[Light, str] | None:
    """The light of surfaces that pass smoothly between steps of depth, and what steps; None where there are none.

    No depth is moved by more than half a step. Over a plane disparity, 1/z, is linear, and stays as it is drawn to the
    mean of its neighbours. Where incidence was told by depth it is told by what is between steps.
    """
    found = _smooth(light)
    if found is None:
        return None
    times, facing, said = found
    if light.part_of is not None:
        times, facing = (a[light.part_of[1]] for a in (times, facing))
    ways = tuple(Return(way.range_m * times, way.strength * facing / times**2) for way in light.returns)
    return replace(light, returns=ways), said


@kept_of_session
def _smooth(every: Light) -> tuple[np.ndarray, np.ndarray, str] | None:
    """(F, H, W) float32 each: how many times as far surfaces are as depth says, how many times as large the cosine of
    incidence is; and what depth steps by.
    """
    length = np.linalg.norm(every.rays, axis=-1)
    asked = every.range_m[:: max(every.frames // ASKED, 1)] / length
    asked = asked[np.isfinite(asked) & (asked > 0)].astype(float)
    for what, power in (("1/m", -1), ("m", 1)):
        step = step_of(asked**power)
        if step is not None:
            depth = every.range_m / length
            known = np.isfinite(depth) & (depth > 0)
            steps = np.where(known, np.where(known, depth, 1.0).astype(float) ** power / step, -np.inf)
            smooth = np.stack(in_parallel(drawn_together, steps))
            times = np.where(known, smooth / np.where(known, steps, 1.0), 1.0) ** power
            facing = _facing(every, np.where(known, depth, 0), np.where(known, depth * times, 0))
            return times.astype(np.float32), facing.astype(np.float32), f"{step:.3g} {what}"
    return None


def _facing(every: Light, depth: np.ndarray, smooth: np.ndarray) -> np.ndarray:
    """(F, H, W) ratio of cosines as told by one depth to those by another, where these are those of the light."""
    for told in (incidence_cosine, incidence_cosine_across_edges):
        before = told(depth, every.intrinsics)
        there = np.isfinite(before) & (before > 0)
        if there.any() and (np.abs(before - every.cosine)[there] < ALIKE).mean() > MOST:
            after = told(smooth, every.intrinsics)
            return np.where(there & np.isfinite(after), np.maximum(after, 0) / np.where(there, before, 1), 1.0)
    return np.ones_like(depth)


def step_of(numbers: np.ndarray) -> float | None:
    """The step that numbers (N,) are whole multiples of, but for an offset; None if they are not."""
    ordered = np.sort(numbers)
    gaps = np.diff(ordered)
    gaps = gaps[gaps > ROUNDED * ordered[1:]]
    if len(gaps) + 1 < FEWEST or (len(gaps) + 1) * PIXELS > len(ordered):
        return None
    step = float(gaps.min())
    steps = gaps / step
    return step if (np.abs(steps - np.rint(steps)) < OFF).mean() >= MOST else None


@njit(nogil=True, cache=True)
def drawn_together(steps):
    """(H, W) numbers of steps, drawn to the mean of what is of the same surface on either side, by half at most."""
    height, width = steps.shape
    now, then = steps.copy(), steps.copy()
    for _ in range(TURNS):
        for v in range(height):
            for u in range(width):
                total, many, here = 0.0, 0, steps[v, u]
                if 0 < u < width - 1 and abs(steps[v, u - 1] - here) <= APART and abs(steps[v, u + 1] - here) <= APART:
                    total, many = total + now[v, u - 1] + now[v, u + 1], many + 2
                if 0 < v < height - 1 and abs(steps[v - 1, u] - here) <= APART and abs(steps[v + 1, u] - here) <= APART:
                    total, many = total + now[v - 1, u] + now[v + 1, u], many + 2
                if many:
                    then[v, u] = min(max(total / many, here - 0.5), here + 0.5)
        now, then = then, now
    return now

"""Surfaces of one histogram, refined: their counts and ranges by scoring, with errors."""

import numpy as np
from numba import njit

# Light is spread over ranges where that is so many standard errors above none.
SPREAD = 2.0
ROUNDS_FIRST, ROUNDS = 2, 3
# Steps of the finer table over which a pulse is seen to bend: half a bin.
APART = 4


@njit(nogil=True, cache=True)
def describe(light, humps, range_m, response, bands, fine_m, fine, structure, level, counts, held):
    """Of each of K humps: counts, error of counts, mean range, error of range, spread of ranges, (K, 5); and the level.

    light: (B,) units from each range; humps: (K, 2) which of it is whose. response: (B, T), bands: (B, 2); fine: (R, T)
    response at closer ranges fine_m (R,), between which a surface's place is free.
    A hump is a surface of one range unless the histogram tells that its light is spread; then it is what it is, and may
    shift and widen. Fisher's scoring of light, place and width of all, and of the level unless it is `held`, with the
    information Σ_t ∂m ∂m / m at expected counts m; its inverse is their covariance (Lehmann & Casella, Theory of Point
    Estimation, 2nd ed., §6.4: from a start that is near, a step is efficient).
    """
    many, bins = len(humps), len(counts)
    moulds, thin = np.zeros((many, 3, bins)), np.zeros((many, 3, bins))
    # Of each hump: units, range, variance of range beyond that of its mould.
    start, spread = np.zeros((many, 3)), np.zeros(many)
    for k in range(many):
        start[k, 0], start[k, 1], spread[k] = _mould(light, humps[k], range_m, response, bands, moulds[k])
    now, wide, every = start.copy(), np.zeros(many, np.bool_), np.ones(many, np.bool_)
    for i in range(ROUNDS_FIRST):
        for k in range(many):
            _at(now[k, 1], fine_m, fine, thin[k])
        widths = every if i == ROUNDS_FIRST - 1 else wide
        change, covariance, _ = _step(thin, now, widths, structure, level, counts, held)
        level = _moved(now, change, level, range_m)
    for k in range(many):
        wide[k] = now[k, 2] > SPREAD * np.sqrt(covariance[3 * k + 2, 3 * k + 2])
        if wide[k]:
            now[k] = start[k]
        now[k, 2] = 0.0
    shapes, reached = moulds.copy(), np.zeros(many)
    for _ in range(ROUNDS):
        for k in range(many):
            if wide[k]:
                shapes[k, 0] = moulds[k, 0] + (now[k, 1] - start[k, 1]) * moulds[k, 1]
            else:
                _at(now[k, 1], fine_m, fine, shapes[k])
        change, covariance, reached = _step(shapes, now, wide, structure, level, counts, held)
        level = _moved(now, change, level, range_m)
    found = np.zeros((many, 5))
    for k in range(many):
        found[k, 0] = now[k, 0] * reached[k]
        found[k, 1] = np.sqrt(max(covariance[3 * k, 3 * k], 0.0)) * reached[k]
        found[k, 2] = now[k, 1]
        found[k, 3] = np.sqrt(max(covariance[3 * k + 1, 3 * k + 1], 0.0))
        found[k, 4] = np.sqrt(max(spread[k] ** 2 + now[k, 2], 0.0))
    return found, level


@njit(nogil=True, cache=True)
def _step(shapes, now, wide, structure, level, counts, held):
    """One step of scoring: change and covariance of (units, place, variance) of each hump and the level; counts a unit.

    shapes: (K, 3, T) histogram of a unit, its slope with range and with variance. Widths that are not `wide` stay.
    """
    many, bins = len(now), len(counts)
    free = 3 * many + 1
    slopes = np.zeros((free, bins))
    made = structure + level
    reached = np.zeros(many)
    for k in range(many):
        for t in range(bins):
            slopes[3 * k, t] = max(shapes[k, 0, t] + now[k, 2] * shapes[k, 2, t], 0.0)
            slopes[3 * k + 1, t] = now[k, 0] * shapes[k, 1, t]
            if wide[k]:
                slopes[3 * k + 2, t] = now[k, 0] * shapes[k, 2, t]
            made[t] += now[k, 0] * slopes[3 * k, t]
            reached[k] += slopes[3 * k, t]
    if not held:
        slopes[free - 1] = 1.0
    weighed = slopes / np.maximum(made, 1e-9)
    information = weighed @ slopes.T
    scale = np.sqrt(np.maximum(np.diag(information), 1e-12))
    # A ridge keeps humps that no histogram can tell apart from dividing by nothing; their errors become large.
    relative = information / np.outer(scale, scale) + 1e-9 * np.eye(free)
    for j in range(free):
        if information[j, j] == 0.0:
            relative[j, j] = 1.0
    covariance = np.linalg.inv(relative) / np.outer(scale, scale)
    return covariance @ (weighed @ (counts - made)), covariance, reached


@njit(nogil=True, cache=True)
def _moved(now, change, level, range_m):
    """Move humps `now` (K, 3) in place; the new level."""
    # Of range, no more than is linear.
    longest = range_m[1] - range_m[0]
    for k in range(len(now)):
        now[k, 0] = max(now[k, 0] + change[3 * k], 0.1 * now[k, 0])
        place = now[k, 1] + min(max(change[3 * k + 1], -longest), longest)
        now[k, 1] = min(max(place, range_m[0]), range_m[-1])
        now[k, 2] += change[3 * k + 2]
    return max(level + change[-1], 0.1 * level)


@njit(nogil=True, cache=True)
def _at(place, fine_m, fine, shape):
    """Fill the histogram (T,) of a unit from the range `place`, and its slopes with range and variance of range."""
    at = min(max(np.searchsorted(fine_m, place) - 1, 0), len(fine_m) - 2)
    step = fine_m[at + 1] - fine_m[at]
    part = (place - fine_m[at]) / step
    back, ahead = max(at - APART, 0), min(at + APART, len(fine_m) - 2)
    for t in range(shape.shape[1]):
        shape[0, t] = (1 - part) * fine[at, t] + part * fine[at + 1, t]
        shape[1, t] = (fine[at + 1, t] - fine[at, t]) / step
        around = (1 - part) * (fine[back, t] + fine[ahead, t]) + part * (fine[back + 1, t] + fine[ahead + 1, t])
        shape[2, t] = (around / 2 - shape[0, t]) / (APART * step) ** 2
        # From the line between two steps to the curve through them.
        shape[0, t] -= part * (1 - part) * step**2 * shape[2, t]
        shape[1, t] += (2 * part - 1) * step * shape[2, t]


@njit(nogil=True, cache=True)
def _mould(light, hump, range_m, response, bands, shape):
    """Units, mean range and spread of a hump; fills its histogram by unit, and its slopes, as `_at` does, (3, T)."""
    units = first = second = 0.0
    for b in range(hump[0], hump[1]):
        if light[b] > 0:
            units += light[b]
            first += light[b] * range_m[b]
            second += light[b] * range_m[b] ** 2
    for b in range(hump[0], hump[1]):
        if light[b] > 0:
            ahead, back = min(b + 1, len(range_m) - 1), max(b - 1, 0)
            share = light[b] / units
            apart = range_m[ahead] - range_m[back]
            for t in range(bands[back, 0], bands[ahead, 1]):
                shape[0, t] += share * response[b, t]
                shape[1, t] += share / apart * (response[ahead, t] - response[back, t])
                around = response[ahead, t] + response[back, t]
                shape[2, t] += share * (around / 2 - response[b, t]) / (apart / 2) ** 2
    mean = first / units
    return units, mean, np.sqrt(max(second / units - mean * mean, 0.0))

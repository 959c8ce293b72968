"""Surfaces of one histogram, refined: their counts and ranges by scoring, with errors."""

import numpy as np
from numba import njit

# Light that is spread by less than this part of what can be told apart is taken to come from one range.
THIN = 0.2
ROUNDS = 3


@njit(nogil=True, cache=True)
def describe(light, humps, range_m, response, bands, fine_m, fine, structure, level, counts, held, near_m):
    """Of each of K humps: counts, error of counts, mean range, error of range, spread of ranges, (K, 5); and the level.

    light: (B,) units from each range; humps: (K, 2) which of it is whose. response: (B, T), bands: (B, 2); fine: (R, T) response
    at closer ranges fine_m (R,), between which a surface's place is free.
    A hump is a surface of one range where its spread is below what noise makes of one, else what it is, and may shift.
    Fisher's scoring of light and place of all, and of the level unless it is `held`, with the information
    Σ_t ∂m ∂m / m at expected counts m; its inverse is their covariance (Lehmann & Casella, Theory of Point Estimation,
    2nd ed., §6.4: from a start that is near, a step is efficient).
    """
    many, bins = len(humps), len(counts)
    free = 2 * many + (0 if held else 1)
    found, shape, slope = np.zeros((many, 5)), np.zeros((many, bins)), np.zeros((many, bins))
    units, moved = np.zeros(many), np.zeros(many)
    for k in range(many):
        units[k], found[k, 2], found[k, 4] = _mould(light, humps[k], range_m, response, bands, shape[k], slope[k])
    thin = found[:, 4] < THIN * near_m
    slopes, covariance = np.zeros((free, bins)), np.zeros((free, free))
    if not held:
        slopes[free - 1] = 1.0
    for _ in range(ROUNDS):
        made = structure + level
        for k in range(many):
            if thin[k]:
                _at(found[k, 2], fine_m, fine, shape[k], slope[k])
            slopes[k] = np.maximum(shape[k] + moved[k] * slope[k], 0.0)
            slopes[many + k] = units[k] * slope[k]
            made += units[k] * slopes[k]
        weighed = slopes / np.maximum(made, 1e-9)
        information = weighed @ slopes.T
        scale = np.sqrt(np.maximum(np.diag(information), 1e-12))
        # A ridge keeps humps that no histogram can tell apart from dividing by nothing; their errors become large.
        covariance = np.linalg.inv(information / np.outer(scale, scale) + 1e-9 * np.eye(free)) / np.outer(scale, scale)
        change = covariance @ (weighed @ (counts - made))
        for k in range(many):
            # Of range, no more than is linear.
            longest = range_m[1] - range_m[0]
            before = found[k, 2]
            place = before + min(max(change[many + k], -longest), longest)
            found[k, 2] = min(max(place, range_m[0]), range_m[-1])
            moved[k] += 0.0 if thin[k] else found[k, 2] - before
            units[k] = max(units[k] + change[k], 0.1 * units[k])
        if not held:
            level = max(level + change[free - 1], 0.1 * level)
    for k in range(many):
        found[k, 0] = units[k] * slopes[k].sum()
        found[k, 1] = np.sqrt(max(covariance[k, k], 0.0)) * slopes[k].sum()
        found[k, 3] = np.sqrt(max(covariance[many + k, many + k], 0.0))
    return found, level


@njit(nogil=True, cache=True)
def _at(place, fine_m, fine, shape, slope):
    """Fill the histogram (T,) of a unit from the range `place`, and how that changes with range."""
    at = min(max(np.searchsorted(fine_m, place) - 1, 0), len(fine_m) - 2)
    step = fine_m[at + 1] - fine_m[at]
    part = (place - fine_m[at]) / step
    for t in range(len(shape)):
        shape[t] = (1 - part) * fine[at, t] + part * fine[at + 1, t]
        slope[t] = (fine[at + 1, t] - fine[at, t]) / step


@njit(nogil=True, cache=True)
def _mould(light, hump, range_m, response, bands, shape, slope):
    """Units, mean range and spread of a hump; fills its histogram by unit, and how that changes with a shift, (T,)."""
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
            by_metre = share / (range_m[ahead] - range_m[back])
            for t in range(bands[back, 0], bands[ahead, 1]):
                shape[t] += share * response[b, t]
                slope[t] += by_metre * (response[ahead, t] - response[back, t])
    mean = first / units
    return units, mean, np.sqrt(max(second / units - mean * mean, 0.0))

"""A distribution of light over ranges becomes a few surfaces, with errors."""

import numpy as np
from numba import njit

from fusion.scoring import describe

# Two humps are two surfaces where light falls to less than this part of the lower one between them.
VALLEY = 0.5
# A surface is one where its counts exceed their standard error so many times.
CERTAIN = 5.0


@njit(nogil=True, cache=True)
def surfaces(light, range_m, response, bands, fine_m, fine, structure, level, counts, held, near_m, most):
    """Up to `most` surfaces of one histogram, brightest first: rows as `describe` gives them, (K, 5), and the level.

    light: (B,) units that came from each range; response (B, T), bands (B, 2) of this zone; fine
    (R, T) the same at closer ranges fine_m (R,). A hump whose counts are not
    certain is joined with the nearer neighbour where that lies within `near_m`, and dropped otherwise.
    """
    light = light.copy()
    humps = divide(light)
    amount, place = gist(light, humps, range_m, response, bands)
    # Photon noise alone makes fewer counts uncertain, so no more need be known of them.
    while len(humps) and (amount.min() < CERTAIN**2 or len(humps) > 3 * most):
        humps = resolved(int(np.argmin(amount)), humps, place, light, near_m)
        amount, place = gist(light, humps, range_m, response, bands)
    found = np.zeros((0, 5))
    while len(humps):
        found, better = describe(light, humps, range_m, response, bands, fine_m, fine, structure, level, counts, held)
        certain = found[:, 0] / np.maximum(found[:, 1], 1e-9)
        if certain.min() >= CERTAIN and len(humps) <= most:
            return found[np.argsort(-found[:, 0])], better
        humps = resolved(int(np.argmin(certain)), humps, found[:, 2], light, near_m)
    return found[:0], level


@njit(nogil=True, cache=True)
def divide(light):
    """(K, 2) first entry of each hump of light (B,), and the one after its last; without those that are empty."""
    edges = [0]
    peak, valley, at = 0.0, np.inf, 0
    for b in range(len(light)):
        if light[b] < valley:
            valley, at = light[b], b
        if valley < VALLEY * peak and light[b] > valley / VALLEY:
            edges.append(at)
            peak, valley, at = light[b], light[b], b
        elif light[b] > peak:
            peak, valley, at = light[b], light[b], b
    edges.append(len(light))
    kept = [(edges[k], edges[k + 1]) for k in range(len(edges) - 1) if light[edges[k] : edges[k + 1]].sum() > 0]
    humps = np.zeros((len(kept), 2), np.int64)
    for k in range(len(kept)):
        humps[k, 0], humps[k, 1] = kept[k]
    return humps


@njit(nogil=True, cache=True)
def gist(light, humps, range_m, response, bands):
    """(K,) counts and (K,) mean range of each hump."""
    amount, place = np.zeros(len(humps)), np.zeros(len(humps))
    for k in range(len(humps)):
        units = 0.0
        for b in range(humps[k, 0], humps[k, 1]):
            if light[b] > 0:
                amount[k] += light[b] * response[b, bands[b, 0] : bands[b, 1]].sum()
                place[k] += light[b] * range_m[b]
                units += light[b]
        place[k] /= max(units, 1e-12)
    return amount, place


@njit(nogil=True, cache=True)
def resolved(k, humps, place, light, near_m):
    """Humps with hump `k` joined to a neighbour, or dropped, its light set to 0."""
    before = place[k] - place[k - 1] if k > 0 else np.inf
    after = place[k + 1] - place[k] if k < len(humps) - 1 else np.inf
    if min(before, after) > near_m:
        light[humps[k, 0] : humps[k, 1]] = 0
    elif before < after:
        humps[k - 1, 1] = humps[k, 1]
    else:
        humps[k + 1, 0] = humps[k, 0]
    return np.concatenate((humps[:k], humps[k + 1 :]))

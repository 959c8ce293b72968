"""From an image of range to one whose zones hold every range as often as their histograms do."""

import numpy as np
from numba import njit

from fusion.edges import Field
from fusion.shares import STEP, Shares

# The ends of an observed distribution are where it leaves 0 and 1 by this much.
WITHIN = 1e-6


def match(
    field: Field,
    image: np.ndarray,
    heard: np.ndarray,
    areas: np.ndarray,
    observed: Shares,
    steps: int,
    ridge: float,
) -> np.ndarray:
    """(H, W) logarithm of range, `steps` steps down from `image`.

    heard: (Q, H, W) weight of each pixel's disagreement; no pixel's should sum to more than 1, lest it pass its goal.
    areas: (Q, H, W) weight of each pixel in its zone's histogram. ridge: the least of the field's; where it has more, a
    pixel is held where it is. The descent is that of `pull`, with the field's covariance in front (a Sobolev gradient:
    Neuberger 1997): what moves does so together with what it belongs to by colour, and stopping early keeps what was
    smooth.
    """
    flat = np.ascontiguousarray(areas.reshape(len(areas), -1), float)
    how = np.ascontiguousarray(heard.reshape(len(heard), -1), float)
    now = np.ascontiguousarray(image, float)
    for _ in range(steps):
        slope = pull(now.ravel(), flat, how, observed.cumulative, observed.log_m[0], STEP)
        now = now + ridge * field.solve(slope.reshape(field.shape))
    return now


@njit(nogil=True, cache=True)
def pull(image, areas, heard, observed, first, step):
    """(N,) sum over zones of `heard` times how far each pixel's value is pulled.

    With F and F° the cumulative distributions of the image in the zone and of what was observed, that is F(x) - F°(x).
    With `heard` equal to `areas`, each of which sums to 1, it is minus the gradient of the Cramér distance
    Σ ½∫(F - F°)² dx (Székely & Rizzo 2013, Energy statistics). Where a distribution is narrow that would throw a
    value past its goal, so none is pulled further than F°⁻¹(F(x)), where it belongs; the sign of both is the same.
    """
    zones, pixels = areas.shape
    bins = observed.shape[1]
    sums = np.zeros(pixels)
    for p in range(zones):
        rank = ranks(image, areas[p], bins, first, step)
        goal = goals(rank, observed[p], first, step)
        for i in range(pixels):
            if heard[p, i] > 0:
                place = min(max((image[i] - first) / step, 0.0), bins - 1.001)
                b = int(place)
                lead = rank[b] - observed[p, b]
                lead += (rank[b + 1] - observed[p, b + 1] - lead) * (place - b)
                way = goal[b] + (goal[b + 1] - goal[b]) * (place - b) - image[i]
                sums[i] += heard[p, i] * (min(max(lead, 0.0), max(way, 0.0)) + max(min(lead, 0.0), min(way, 0.0)))
    return sums


@njit(nogil=True, cache=True)
def ranks(image, areas, bins, first, step):
    """(B,) part of the areas (N,) whose value is less than each of B evenly spaced ones."""
    held = np.zeros(bins)
    for i in range(len(image)):
        if areas[i] > 0:
            place = min(max((image[i] - first) / step, 0.0), bins - 1.001)
            b = int(place)
            held[b] += areas[i] * (1 - place + b)
            held[b + 1] += areas[i] * (place - b)
    # Half of what a bin holds is less than its middle.
    return (np.cumsum(held) - held / 2) / max(held.sum(), 1e-30)


@njit(nogil=True, cache=True)
def goals(rank, observed, first, step):
    """(B,) value at which the observed distribution (B,) reaches each rank."""
    found = np.empty(len(rank))
    at = 1
    for b in range(len(rank)):
        part = min(max(rank[b], WITHIN), 1 - WITHIN)
        while at < len(observed) - 1 and observed[at] < part:
            at += 1
        found[b] = first + step * (at - 1 + (part - observed[at - 1]) / (observed[at] - observed[at - 1]))
    return found

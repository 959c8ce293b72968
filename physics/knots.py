"""Light on the knots of the lattice: the loops that add it up, move it and put it into bins, compiled."""

import numpy as np
from numba import njit

# Bins that are filled at once.
TOGETHER = 4


@njit(nogil=True, cache=True)
def splat_knots(ranges, strength, pixels, weights, offset, per_metre, out):
    """Add light of F frames' N pixels, with weights (N, P), to (F, P, J) knots."""
    zones, last = out.shape[1], out.shape[2] - 1
    by_knot = np.zeros((0, zones))
    for f in range(out.shape[0]):
        first_zone, last_zone = offset[f].min(), offset[f].max()
        if first_zone == last_zone:
            if by_knot.size == 0:
                by_knot = np.zeros((out.shape[2], zones))
            _splat_together(ranges[f], strength[f], pixels, weights, first_zone, per_metre, by_knot, out[f])
            continue
        for i in range(pixels.size):
            light = float(strength[f, pixels[i]])
            if not light > 0:
                continue
            travel = ranges[f, pixels[i]] * per_metre
            if travel + first_zone >= 0 and travel + last_zone < last:
                for p in range(zones):  # No zone has to be asked.
                    _share(travel + offset[f, p], light * weights[i, p], out[f, p])
                continue
            for p in range(zones):
                at = travel + offset[f, p]
                if 0 <= at < last:
                    _share(at, light * weights[i, p], out[f, p])


@njit(nogil=True, cache=True)
def _splat_together(ranges, strength, pixels, weights, offset, per_metre, by_knot, out):
    """The same of one frame whose zones have one offset, so that a pixel's light is at the same knots in all of them.

    by_knot: (J, P) zeros, and zeros again afterwards: zones lie side by side there, and the compiler takes several at
    once.
    """
    zones, last = out.shape[0], out.shape[1] - 1
    low, high = last, -1
    for i in range(pixels.size):
        light = float(strength[pixels[i]])
        at = ranges[pixels[i]] * per_metre + offset
        if not (light > 0 and 0 <= at < last):
            continue
        whole = np.int64(at)
        low, high = min(low, whole), max(high, whole + 1)
        later = light * (at - whole)
        here, there, weight = by_knot[np.uint64(whole)], by_knot[np.uint64(whole + 1)], weights[i]
        for p in range(zones):
            here[p] += (light - later) * weight[p]
            there[p] += later * weight[p]
    for knot in range(low, high + 1):
        for p in range(zones):
            out[p, knot] += by_knot[knot, p]
            by_knot[knot, p] = 0.0


@njit(nogil=True, cache=True, inline="always")
def _share(at, given, row):
    """Give light to the two knots of a row about `at`."""
    whole = np.int64(at)
    knot = np.uint64(whole)  # An index without sign: no test whether it counts from the end.
    later = given * (at - whole)
    row[knot] += given - later
    row[knot + np.uint64(1)] += later


@njit(nogil=True, cache=True)
def where_lit(row):
    """Where in a row the first light is, and where the last ends; most of a row is dark."""
    begin, end = 0, row.size
    while begin < end and row[begin] == 0:
        begin += 1
    while begin < end and row[end - 1] == 0:
        end -= 1
    return begin, end


@njit(nogil=True, cache=True)
def add_later(row, begin, end, by, part, out):
    """Add this part of what a row has from `begin` to `end` to knots `by` later, as far as there are any."""
    first, last = max(begin, -by), min(end, out.size - by)
    if first < last:
        # As rows of their own, whose indices have no sign to be asked for.
        given, there = row[first:last], out[first + by : last + by]
        for j in range(given.size):
            there[j] += part * given[j]


@njit(nogil=True, cache=True)
def delay_knots(light, steps, out):
    """Fill (F, P, J) knots with those of `light`, each row later by its own number of steps, earlier where negative."""
    frames, zones, size = light.shape
    for f in range(frames):
        for p in range(zones):
            # Beyond the lattice either way all is gone.
            by = min(max(steps[f, p], -size - 1.0), size + 1.0)
            whole = np.int64(np.floor(by))
            later = by - whole
            begin, end = where_lit(light[f, p])
            row, moved = light[f, p], out[f, p]
            moved[:] = 0.0
            add_later(row, begin, end, whole, 1 - later, moved)
            add_later(row, begin, end, whole + 1, later, moved)


@njit(nogil=True, cache=True)
def stretch_knots(light, factor, about, out):
    """Add light of (F, P, J) knots to those `factor` times as far from knot `about`, (F, P) each, as they are."""
    frames, zones, size = light.shape
    for f in range(frames):
        for p in range(zones):
            for j in range(size):
                at = about[f, p] + factor[f, p] * (j - about[f, p])
                if light[f, p, j] != 0 and 0 <= at < size - 1:
                    knot = np.int64(at)
                    later = light[f, p, j] * (at - knot)
                    out[f, p, knot] += light[f, p, j] - later
                    out[f, p, knot + 1] += later


@njit(nogil=True, cache=True, fastmath={"reassoc", "contract"})
def until_knots(light, backward, over, out):
    """Fill (F, P, N) with light of (F, P, J) knots that is registered `over` steps (P, N) after knot 0 sets in.

    backward: cumulative of the response from its last step to its first; linear within a step.
    """
    frames, zones, _ = light.shape
    last = backward.size - 1
    for f in range(frames):
        for p in range(zones):
            row = light[f, p]
            begin, end = where_lit(row)
            summed = np.zeros(end - begin + 1)
            for j in range(begin, end):
                summed[j - begin + 1] = summed[j - begin] + row[j]
            for n in range(over.shape[1]):
                step = np.int64(np.floor(over[p, n]))
                part = over[p, n] - step
                # Of knots before `whole` all is registered, of those from `step` on nothing.
                whole = min(max(step - last + 1, begin), end)
                since, now, later = last - step + whole, 0.0, 0.0
                lit, before, after = row[whole:], backward[since:], backward[since - 1 :]
                for j in range(min(step + 1, end) - whole):
                    # Indices without sign, as above: the compiler takes several at once.
                    i = np.uint64(j)
                    now += lit[i] * before[i]
                    later += lit[i] * after[i]
                out[f, p, n] = summed[whole - begin] + now + part * (later - now)


@njit(nogil=True, cache=True, fastmath={"reassoc", "contract"})
def bin_knots(light, shares, per_bin, first, out):
    """Fill (F, P, T) bins from (F, P, J) knots; `shares` of bin 0 are those of knots `first` and later."""
    frames, zones, _ = light.shape
    bins, pad = out.shape[2], (TOGETHER - 1) * per_bin
    # Bins are filled several at a time, so that a knot is fetched once for them: each one's shares begin and end in 0.
    padded = np.zeros(shares.size + 2 * pad)
    padded[pad : pad + shares.size] = shares
    for f in range(frames):
        for p in range(zones):
            row = light[f, p]
            begin, end = where_lit(row)
            for t in range(0, bins, TOGETHER):
                at = first + t * per_bin
                low, high = max(begin, at), min(end, at + pad + shares.size)
                since = low - at + pad
                w, x, y, z = (
                    padded[since:],
                    padded[since - per_bin :],
                    padded[since - 2 * per_bin :],
                    padded[since - pad :],
                )
                a = b = c = d = 0.0
                for j in range(high - low):
                    # Indices without sign, as above: the compiler takes several at once.
                    knot = np.uint64(j)
                    here = row[np.uint64(low + j)]
                    a += here * w[knot]
                    b += here * x[knot]
                    c += here * y[knot]
                    d += here * z[knot]
                for i, total in enumerate((a, b, c, d)):
                    if t + i < bins:
                        out[f, p, t + i] = total

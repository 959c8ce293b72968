"""Light on the knots of the lattice: the loops that add it up, move it and put it into bins, compiled."""

import numpy as np
from numba import njit


@njit(nogil=True, cache=True)
def splat_knots(ranges, strength, pixels, weights, offset, per_metre, out):
    """Add light of F frames' N pixels, with weights (N, P), to (F, P, J) knots."""
    zones, last = out.shape[1], out.shape[2] - 1
    for f in range(out.shape[0]):
        first_zone, last_zone = offset[f].min(), offset[f].max()
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


@njit(nogil=True, cache=True, inline="always")
def _share(at, given, row):
    """Give light to the two knots of a row about `at`."""
    whole = np.int64(at)
    knot = np.uint64(whole)  # An index without sign: no test whether it counts from the end.
    later = given * (at - whole)
    row[knot] += given - later
    row[knot + np.uint64(1)] += later


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
            out[f, p] = 0.0
            for j in range(max(whole, 0), min(whole, 0) + size):
                out[f, p, j] += (1 - later) * light[f, p, j - whole]
            for j in range(max(whole + 1, 0), min(whole + 1, 0) + size):
                out[f, p, j] += later * light[f, p, j - whole - 1]


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
def bin_knots(light, shares, per_bin, first, out):
    """Fill (F, P, T) bins from (F, P, J) knots; `shares` of bin 0 are those of knots `first` and later."""
    frames, zones, knots = light.shape
    for f in range(frames):
        for p in range(zones):
            row = light[f, p]
            begin, end = 0, knots
            while begin < end and row[begin] == 0:
                begin += 1
            while begin < end and row[end - 1] == 0:
                end -= 1
            for t in range(out.shape[2]):
                at = first + t * per_bin
                low, high = max(begin, at), min(end, at + shares.size)
                total = 0.0
                for j in range(high - low):
                    # Indices without sign, as above: the compiler takes several at once.
                    total += row[np.uint64(low + j)] * shares[np.uint64(low - at + j)]
                out[f, p, t] = total

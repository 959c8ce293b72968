"""What patches get of one another's light, and the zones that see them of that.

One patch after the other gathers what arrives from all others, and hands it on to the zones that see it: few do. Loops
write to one array each and ask nothing, so that compilers work out several pairs at once.
"""

import numpy as np
from numba import njit

# Product of the cosines between rough surfaces.
ROUGH = 0.25
NOTHING = 1e-300


@njit(nogil=True, cache=True, error_model="numpy")
def exchange(point, normal, area, sent, response, rough, per_metre, first, out):
    """Add what each of N patches gets of all others, as zones see it, to (P, J) knots.

    point, normal: (N, 3). area, sent: (N,). response: (N, P). rough: whether light goes whichever way they face.
    per_metre: knots that light takes for a metre. first: the knot of no way at all.
    """
    count, last = area.size, out.shape[1] - 1
    x, y, z = point[:, 0].copy(), point[:, 1].copy(), point[:, 2].copy()
    right, down, ahead = normal[:, 0].copy(), normal[:, 1].copy(), normal[:, 2].copy()
    far = np.sqrt(x * x + y * y + z * z)
    at, given, arrived = np.empty(count), np.empty(count), np.empty(last + 1)
    for i in range(count):
        if not response[i].any():
            continue
        _arrival(x, y, z, far, i, per_metre, first, at)
        if rough:
            _given_by_rough(x, y, z, area, sent, i, given)
        else:
            _given_by_smooth(x, y, z, right, down, ahead, area, sent, i, given)
        given[i] = 0.0
        arrived[:] = 0.0
        low, high = last + 1, 0
        for j in range(count):
            if given[j] > 0 and 0 <= at[j] < last:
                knot = np.uint64(at[j])
                later = given[j] * (at[j] - np.int64(knot))
                arrived[knot] += given[j] - later
                arrived[knot + np.uint64(1)] += later
                low, high = min(low, np.int64(knot)), max(high, np.int64(knot) + 2)
        for p in range(len(out)):
            seen = response[i, p]
            if seen:
                for k in range(low, high):
                    out[p, k] += seen * arrived[k]


@njit(nogil=True, cache=True, error_model="numpy")
def _arrival(x, y, z, far, i, per_metre, first, at):
    """At which knot light arrives that goes by way of each patch to the i-th, and back."""
    for j in range(at.size):
        dx, dy, dz = x[i] - x[j], y[i] - y[j], z[i] - z[j]
        at[j] = (far[j] + np.sqrt(dx * dx + dy * dy + dz * dz) + far[i]) * per_metre + first


@njit(nogil=True, cache=True, error_model="numpy")
def _given_by_rough(x, y, z, area, sent, i, given):
    """What the i-th patch gets of each whichever way they face."""
    for j in range(given.size):
        dx, dy, dz = x[i] - x[j], y[i] - y[j], z[i] - z[j]
        given[j] = ROUGH * sent[j] / (np.pi * (dx * dx + dy * dy + dz * dz) + area[j])


@njit(nogil=True, cache=True, error_model="numpy")
def _given_by_smooth(x, y, z, right, down, ahead, area, sent, i, given):
    """What the i-th patch gets of each matt one that faces it, by the cosines of both."""
    for j in range(given.size):
        dx, dy, dz = x[i] - x[j], y[i] - y[j], z[i] - z[j]
        square = dx * dx + dy * dy + dz * dz
        leaving = right[j] * dx + down[j] * dy + ahead[j] * dz
        coming = -(right[i] * dx + down[i] * dy + ahead[i] * dz)
        # Each with its magnitude is twice itself, or nothing where it faces away.
        facing = (leaving + abs(leaving)) * (coming + abs(coming)) / 4
        given[j] = sent[j] * facing / ((np.pi * square + area[j]) * (square + NOTHING))

"""Light that is passed on: less of it arrives when it did, and what becomes of the rest arrives later."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numba import njit

from physics.arrivals import Arrivals
from physics.knots import add_later, where_lit
from physics.workers import in_slices


def passed_on(first: Arrivals, lost: np.ndarray, later: Sequence[tuple[np.ndarray, float]]) -> Arrivals:
    """Arrivals less the part of them that is lost, and with other parts that arrive later, earlier where negative.

    lost: part of the light at each knot, anything that broadcasts to (F, P, J). later: parts of the light as it was,
    each with its delay in seconds. Light between two knots is given to both in proportion, as by `Arrivals.delayed`.
    """
    light, out = np.ascontiguousarray(first.light), np.empty(first.light.shape)
    # One row for all frames, or all zones, where they are alike.
    row = np.empty((1, 1, light.shape[2]))
    *parts, _ = np.broadcast_arrays(lost, *(part for part, _ in later), row)
    parts = np.stack(parts)
    steps = np.array([delay_s / first.lattice.step_s for _, delay_s in later])

    def pass_on(some: slice) -> None:
        these = parts if parts.shape[1] == 1 else np.ascontiguousarray(parts[:, some])
        _pass_on(light[some], these, steps, out[some])

    in_slices(pass_on, len(light))
    return replace(first, light=out)


@njit(nogil=True, cache=True)
def _pass_on(light, parts, steps, out):
    """Fill (F, P, J) knots. parts: (1 + N, F or 1, P or 1, J) the one that is lost, and N later by steps (N,)."""
    frames, zones, size = light.shape
    given = np.empty(size)
    for f in range(frames):
        for p in range(zones):
            frame, zone = min(f, parts.shape[1] - 1), min(p, parts.shape[2] - 1)
            row, moved, lost = light[f, p], out[f, p], parts[0, frame, zone]
            begin, end = where_lit(row)
            moved[:] = 0.0
            for j in range(begin, end):
                moved[j] = row[j] * (1 - lost[j])
            for i in range(steps.size):
                part = parts[i + 1, frame, zone]
                for j in range(begin, end):
                    given[j] = row[j] * part[j]
                # Beyond the lattice either way all is gone.
                at = min(max(steps[i], -size - 1.0), size + 1.0)
                whole = np.int64(np.floor(at))
                after = at - whole
                add_later(given, begin, end, whole, 1 - after, moved)
                add_later(given, begin, end, whole + 1, after, moved)

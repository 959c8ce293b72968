"""What the scene sends back between the times of its frames."""

from dataclasses import replace

import numpy as np
from numba import njit

from physics.light import Light, Return
from physics.workers import in_parallel
from recordings.refusal import Refusal

# Where range changes between two frames by more than this part of itself, beyond what most of the image does, an edge
# has passed.
JUMP = 0.05
# Part of its range that is left at least of a surface that moves on.
LEAST = 0.1


def light_at(light: Light, time_s: np.ndarray, beyond: float = 0.0) -> Light:
    """The light at `time_s` (F,), seconds as in `light.time_s`: pixel by pixel linear between the frames around it.

    Before the first frame and after the last it is theirs, or by the part `beyond` of the time, at most one frame's,
    what it becomes as it moves on as it did. Where a value is known in one of the two frames alone it is
    that one's; strength, which is 0 where nothing is known, still rises or fades in between, so that light is
    continuous in time. Where range jumps from one frame to the next, by more than `JUMP` beyond the median pixel, an
    edge has passed, and between its two sides there is no surface: what the first frame's surface returns fades while
    that of the second rises, as a return of its own. Range, reflectance and cosine, by which other effects go, stay
    in between. `time_s` and `laser_cycles` of the frames stay.
    """
    return blended(light, *around(np.asarray(light.time_s, float), np.asarray(time_s, float), beyond))


def from_neighbours(light: Light) -> Light:
    """Each frame as it would be taken to be had it not been seen, from the one before and the one after.

    How far that is off tells what interpolation is worth: where things move on a curve its error goes with the square
    of the time between the two. The first frame and the last are theirs.
    """
    return blended(light, *neighbours(np.asarray(light.time_s, float)))


def neighbours(times: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(F,) each: the frame before and that after each, and how much of the second there is at its time.

    Of the first and the last themselves.
    """
    here = np.arange(len(times))
    lower, upper = np.maximum(here - 1, 0), np.minimum(here + 1, len(times) - 1)
    inner = (lower < here) & (here < upper) & (times[upper] > times[lower])
    part = np.where(inner, (times - times[lower]) / np.where(inner, times[upper] - times[lower], 1), 0)
    return np.where(inner, lower, here), np.where(inner, upper, here), part


def blended(light: Light, lower: np.ndarray, upper: np.ndarray, part: np.ndarray) -> Light:
    """Light part of the way from some frames (F,) to others."""
    made: dict[int, np.ndarray] = {}

    def between(values: np.ndarray, least: float) -> np.ndarray:
        if id(values) not in made:
            out = np.empty_like(values)
            in_parallel(lambda i: _mix(values[lower[i]], values[upper[i]], part[i], least, out[i]), range(len(out)))
            made[id(values)] = out
        return made[id(values)]

    faded, risen = zip(*(_passed(way, lower, upper, part) for way in light.returns), strict=True)
    returns = (*faded, *(way for way in risen if way.strength.any()))
    ranges = between(light.range_m, 0)
    albedo, cosine = between(light.reflectance, -np.inf), between(light.cosine, -np.inf)
    missing = np.count_nonzero(~(ranges > 0) | np.isnan(albedo) | np.isnan(cosine), axis=(1, 2))
    return replace(light, range_m=ranges, reflectance=albedo, cosine=cosine, returns=returns, missing=missing)


def around(frames_s: np.ndarray, time_s: np.ndarray, beyond: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(N,) each: the frames before and after each time, and how much of the second there is, 0 to 1.

    By as much as -1 or 2 before the first frame and after the last, where it goes `beyond`.
    """
    back = np.flatnonzero(np.diff(frames_s) < 0)
    if len(back):
        i = int(back[0]) + 1
        raise Refusal(f"time_s[{i}] is {frames_s[i]:g}, expected {frames_s[i - 1]:g} or later as frames go by time")
    last = len(frames_s) - 1
    ending = max(last - 1, 0) if beyond else last
    lower = np.clip(np.searchsorted(frames_s, time_s, side="right") - 1, 0, ending)
    upper = np.minimum(lower + 1, last)
    span = frames_s[upper] - frames_s[lower]
    exact = (time_s - frames_s[lower]) / np.where(span > 0, span, 1)
    within = np.clip(exact, 0, 1)
    part = within + beyond * np.clip(exact - within, -1, 1)
    return lower, upper, np.where(upper > lower, part, 0.0)


def _passed(way: Return, lower: np.ndarray, upper: np.ndarray, part: np.ndarray) -> tuple[Return, Return]:
    """A way of light between frames, and what of it rises where its range jumps."""
    faded, risen = (Return(np.empty_like(way.range_m), np.empty_like(way.strength)) for _ in range(2))

    def one(i: int) -> None:
        before, after = ((way.range_m[j], way.strength[j]) for j in (lower[i], upper[i]))
        _mix(before[0], after[0], part[i], 0, faded.range_m[i])
        _mix(before[1], after[1], part[i], -np.inf, faded.strength[i])
        typical = _typical_ratio(before[0], after[0]) if part[i] != 0 else 1.0
        _part(*before, *after, part[i], typical, *((of.range_m[i], of.strength[i]) for of in (faded, risen)))

    in_parallel(one, range(len(part)))
    return faded, risen


def _typical_ratio(before: np.ndarray, after: np.ndarray) -> float:
    """Median over pixels of range after over range before; 1 where none is known in both. All that nears is no edge."""
    both = (before > 0) & (after > 0)
    return float(np.median(after[both] / before[both])) if both.any() else 1.0


@njit(nogil=True, cache=True)
def _part(range_before, sent_before, range_after, sent_after, part, typical, faded, risen):
    """Part the light of one frame in two where its range jumps. faded, risen: (H, W) range and strength of each.

    Beyond both frames, where part is less than 0 or more than 1, the nearer frame's surface stays.
    """
    for v in range(range_before.shape[0]):
        for u in range(range_before.shape[1]):
            a, b = range_before[v, u], range_after[v, u]
            risen[0][v, u], risen[1][v, u] = faded[0][v, u], 0
            if part != 0 and a > 0 and b > 0 and max(b / (a * typical), a * typical / b) > 1 + JUMP:
                share = min(max(part, 0.0), 1.0)
                faded[0][v, u], faded[1][v, u] = a, (1 - share) * sent_before[v, u]
                risen[0][v, u], risen[1][v, u] = b, share * sent_after[v, u]
            elif part < 0 or part > 1:
                # What comes near the sensor may not come out behind it, nor send back less than nothing.
                faded[0][v, u] = max(faded[0][v, u], LEAST * max(a, b))
                faded[1][v, u] = max(faded[1][v, u], 0.0)


@njit(nogil=True, cache=True)
def _mix(before, after, part, least, out):
    """Fill (H, W) `out` with the mean of two frames; what is NaN, or not above `least`, is unknown."""
    for v in range(out.shape[0]):
        for u in range(out.shape[1]):
            a, b = before[v, u], after[v, u]
            if part == 0 or not b > least:
                out[v, u] = a if part == 0 or a > least else b
            elif not a > least:
                out[v, u] = b
            else:
                out[v, u] = (1 - part) * a + part * b

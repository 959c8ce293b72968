"""The offset of two clocks from what both sensors saw: the same motion, in two series of values."""

import math

import numpy as np

from recordings.refusal import Refusal

FEWEST = 8
CERTAIN = 12.0  # of log likelihood by which a match must beat chance, and any other match
RISE = 0.3  # of the way from the best match to no match: the part of the valley that is taken for a parabola


def offset_by_events(
    times_a: np.ndarray,
    values_a: np.ndarray,
    times_b: np.ndarray,
    values_b: np.ndarray,
    most_s: float = 1.0,
) -> tuple[float, float]:
    """Seconds that b's clock shows more than a's when both see the same, and their standard deviation.

    times: (N,) and (M,) seconds, ascending, of the middle of each exposure (a sensor that averages over a long one, but
    stamps its end, is late by half of it). values: of any unit, one a linear function of the other up to noise (the
    counts of a zone, the brightness of what it looks at). most_s: largest offset that is looked for; arrivals (see
    `devices.clock`) tell it to that and better.

    Least squares over offset, scale and level at the times of the coarser series, with the other averaged over one of
    its steps. The deviation follows from the curvature there (the Cramer-Rao bound of time delay; Knapp and Carter
    1976, "The generalized correlation method for estimation of time delay"). `Refusal` where nothing matches, or where
    two offsets match alike.
    """
    a, b = _series(times_a, values_a, "first"), _series(times_b, values_b, "second")
    swapped = np.median(np.diff(a[0])) < np.median(np.diff(b[0]))
    coarse, fine = (b, a) if swapped else (a, b)
    lag, sigma = _match(coarse, fine, most_s)
    return (-lag if swapped else lag), sigma


def _series(times: np.ndarray, values: np.ndarray, which: str) -> tuple[np.ndarray, np.ndarray]:
    times, values = np.asarray(times, float), np.asarray(values, float)
    if times.shape != values.shape or times.ndim != 1:
        raise Refusal(f"the {which} series has {times.shape} times and {values.shape} values, expected as many of both")
    known = np.isfinite(times) & np.isfinite(values)
    times, values = times[known], values[known]
    if times.size < FEWEST or np.ptp(values) == 0 or np.any(np.diff(times) <= 0):
        raise Refusal(
            f"the {which} series says nothing, expected values that change at {FEWEST} ascending times or more"
        )
    return times, values


def _match(coarse: tuple[np.ndarray, np.ndarray], fine: tuple[np.ndarray, np.ndarray], most_s: float) -> tuple:
    (t, v), (u, w) = coarse, fine
    # Half of the shorter series must overlap, so that no few samples match by chance.
    need = min(np.ptp(t), np.ptp(u)) / 2
    low, high = max(u[0] - t[-1] + need, -2 * most_s), min(u[-1] - t[0] - need, 2 * most_s)
    lags = np.arange(low, high, float(np.median(np.diff(u))) / 2)
    searched = np.abs(lags) <= most_s  # beyond it is looked, too, so that valleys at the ends are seen whole
    if not searched.any():
        raise Refusal(f"the two series overlap at no offset of {most_s:g} s or less, expected times within that")
    width = float(np.median(np.diff(t)))
    total = np.concatenate([[0.0], np.cumsum(np.diff(u) * (w[1:] + w[:-1]) / 2)])
    unlike, count = np.array([_unlike(t, v, u, total, width, lag) for lag in lags]).T
    best = int(np.argmin(np.where(searched, unlike, np.inf)))
    n = count[best]
    score = -n * np.log(unlike) / 2  # log likelihood above no match at all
    if score[best] < CERTAIN + math.log(lags.size):
        raise Refusal("the two series share no event, expected both sensors to see the same motion")
    lobe = _lobe(unlike, best, unlike[best] + RISE * (1 - unlike[best]))
    outside = np.ones(lags.size, bool)
    outside[max(lobe.start - len(lobe), 0) : lobe.stop + len(lobe)] = False
    if outside.any() and score[best] - score[outside].max() < CERTAIN:
        other = lags[outside][score[outside].argmax()]
        raise Refusal(f"the two series match at {lags[best]:.3f} s as well as at {other:.3f} s, expected one match")
    near = lags[lobe.start : lobe.stop]
    fitted = np.linspace(near[0], near[-1], 41) - lags[best]
    residual = np.array([_unlike(t, v, u, total, width, lags[best] + lag)[0] for lag in fitted])
    square, slope, _ = np.polyfit(fitted, residual, 2)
    if not square > 0:
        raise Refusal("the match of the two series has no clear lowest point, expected a more sudden event")
    lag = lags[best] - slope / (2 * square)
    noise = _unlike(t, v, u, total, width, lag)[0]
    return float(lag), math.sqrt(noise / (max(n - 3, 1) * square))


def _unlike(
    t: np.ndarray, v: np.ndarray, u: np.ndarray, total: np.ndarray, width: float, lag: float
) -> tuple[float, int]:
    """Share of the variance of v that the other series about `t + lag` does not explain, and how many samples overlap.

    total: integral of the other series from its start to u.
    """
    first, last = t + lag - width / 2, t + lag + width / 2
    inside = (first >= u[0]) & (last <= u[-1])
    n = int(inside.sum())
    if n < FEWEST:
        return 1.0, n
    a, b = v[inside], (np.interp(last[inside], u, total) - np.interp(first[inside], u, total)) / width
    a, b = a - a.mean(), b - b.mean()
    power = (a @ a) * (b @ b)
    return (1.0 if power == 0 else max(1 - (a @ b) ** 2 / power, 1e-12)), n


def _lobe(unlike: np.ndarray, best: int, level: float) -> range:
    """Indices around the lowest that stay below a level, two to each side at least."""
    start = stop = best
    while start > 0 and unlike[start - 1] < level:
        start -= 1
    while stop < unlike.size - 1 and unlike[stop + 1] < level:
        stop += 1
    return range(max(min(start, best - 2), 0), min(max(stop, best + 2), unlike.size - 1) + 1)

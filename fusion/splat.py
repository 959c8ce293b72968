"""The direct splat: every pixel takes the mean of what the zones that see it report, weighted by how strongly they do.

    depth(u) = Σ_p w_p(u) · r_p / Σ_p w_p(u) / |ray(u)|

over zones that report a range r_p; w_p are the maps, each divided by its own largest response.
"""

import numpy as np
from numba import njit

from fusion.fused import NO_ZONE
from fusion.sight import Sight
from fusion.zone_view import ZoneDepths
from physics.pages import zeros
from physics.workers import in_parallel
from recordings.refusal import Refusal

BLOCK_ROWS = 32
NOUGHT, ONE = np.float32(0), np.float32(1)

Images = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


def splat(sight: Sight, depths: ZoneDepths) -> Images:
    """Depth, sigma (metres), confidence, all (H, W) float32, and zones (H, W) uint8, of one frame.

    depths: of one frame, (P,). Sigma is the standard deviation of the mixture that the pixel is given: what zones
    report differs, and each sees a mixture. Confidence is the sum of the weights, 1 at most. Footprints are displaced
    by the parallax of each zone's mean range, to the nearest pixel. NaN, and 0 for confidence, where no zone that
    reports a range sees the pixel. Raises `Refusal` where there are other zones than maps.
    """
    if depths.mean_m.shape != (sight.zones,):
        raise Refusal(f"depths are of shape {depths.mean_m.shape}, expected one for each of {sight.zones} zones")
    return splat_ranges(sight, depths.mean_m, depths.deviation_m)


def splat_ranges(sight: Sight, range_m: np.ndarray, deviation_m: np.ndarray) -> Images:
    """The same from a range (P,) and its standard deviation (P,) for each zone, NaN where it reports none."""
    reports = np.flatnonzero(np.isfinite(range_m))
    height = sight.shape[0]
    depth, sigma, confidence = zeros((3, *sight.shape), np.float32)
    zones = np.empty(sight.shape, np.uint8)
    if not len(reports):
        depth.fill(np.nan)
        sigma.fill(np.nan)
        zones.fill(NO_ZONE)
        return depth, sigma, confidence, zones
    moved = np.rint(sight.shift_px(range_m)[reports]).astype(np.int64)
    middle = np.float32(range_m[reports].mean())
    ranges = np.float32(range_m[reports]) - middle
    square = np.float32(np.nan_to_num(deviation_m[reports]) ** 2) + ranges**2

    given = sight.heard, sight.spans, reports, moved, ranges, square, middle, sight.ray_length

    def rows(first: int) -> None:
        _splat(*given, first, min(first + BLOCK_ROWS, height), depth, sigma, confidence, zones)

    in_parallel(rows, range(0, height, BLOCK_ROWS))
    return depth, sigma, confidence, zones


@njit(nogil=True, cache=True, error_model="numpy", fastmath={"contract"})
def _splat(maps, spans, reports, moved, ranges, square, middle, lengths, first, last, depth, sigma, confidence, zones):
    """Fill rows `first` to `last`; ranges (Q,) of zones `reports` are less `middle`, square (Q,) their mean squares."""
    height, width = lengths.shape
    total, once, twice = np.empty(width, np.float32), np.empty(width, np.float32), np.empty(width, np.float32)
    most, who = np.empty(width, np.float32), np.empty(width, np.float32)
    for v in range(first, last):
        total[:], once[:], twice[:], most[:], who[:] = 0, 0, 0, 0, NO_ZONE
        for q in range(len(reports)):
            p, row, across = reports[q], v - moved[q, 1], moved[q, 0]
            if 0 <= row < height:
                begin = max(spans[p, row, 0], -across)
                end = min(spans[p, row, 1], width - across)
                if begin < end:
                    here = slice(begin + across, end + across)
                    _add(maps[p, row, begin:end], ranges[q], square[q], total[here], once[here], twice[here])
                    _lead(maps[p, row, begin:end], np.float32(p), most[here], who[here])
        _deviate(total, once, twice, lengths[v], sigma[v])
        _mean(total, once, middle, lengths[v], depth[v])
        _cap(total, confidence[v])
        _narrow(who, zones[v])


# Each a loop of its own over a row, of few arrays and one type, so that the compiler takes several pixels at once.
@njit(nogil=True, cache=True, fastmath={"contract"})
def _add(weight, once_each, twice_each, total, once, twice):
    for u in range(weight.size):
        total[u] += weight[u]
        once[u] += weight[u] * once_each
        twice[u] += weight[u] * twice_each


@njit(nogil=True, cache=True)
def _lead(weight, zone, most, who):
    for u in range(weight.size):
        # A product where one would write a condition: the compiler takes that one pixel at a time.
        ahead = np.float32(weight[u] > most[u])
        who[u] += ahead * (zone - who[u])
        most[u] += ahead * (weight[u] - most[u])


@njit(nogil=True, cache=True, error_model="numpy", fastmath={"contract"})
def _mean(total, once, middle, lengths, depth):
    for u in range(total.size):
        depth[u] = (middle + once[u] / total[u]) / lengths[u]  # NaN where no zone sees the pixel.


@njit(nogil=True, cache=True, error_model="numpy", fastmath={"contract"})
def _deviate(total, once, twice, lengths, sigma):
    for u in range(total.size):
        mean = once[u] / total[u]
        variance = twice[u] / total[u] - mean * mean
        # Numbers without a type would make all of it double precision.
        sigma[u] = np.sqrt(NOUGHT if variance < NOUGHT else variance) / lengths[u]


@njit(nogil=True, cache=True)
def _cap(total, confidence):
    for u in range(total.size):
        confidence[u] = ONE if total[u] > ONE else total[u]


@njit(nogil=True, cache=True)
def _narrow(who, zones):
    for u in range(who.size):
        zones[u] = np.uint8(np.int32(who[u]))
